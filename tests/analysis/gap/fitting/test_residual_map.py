"""What a fit leaves: white or not, nameless or not, and where."""

import numpy as np
import pytest

from analysis.gap.fitting.fit import fit_gap
from analysis.gap.fitting.gap_fit import relative_misfit
from analysis.gap.fitting.residual_map import residual_map, whiteness
from analysis.gap.search.confidence import unknown_evidence

TEMPERATURES = (10.0, 14.0, 18.0, 22.0)


def bump(frequency, temperature):
    return 1e-3 * np.exp(-(((frequency - 640.0) / 30.0) ** 2)) * (temperature > 15.0)


def fitted(toy, pool, **kwargs):
    sweeps, noise = toy.prepared(temperatures=TEMPERATURES, **kwargs)
    return sweeps, noise, fit_gap(toy.Plate(), sweeps, toy.start(sweeps.groups), (), pool)


def test_noise_is_white_and_leaves_nothing_to_the_unknown(toy, pool):
    sweeps, noise, fit = fitted(toy, pool)
    assert max(map(abs, whiteness(sweeps, fit.residual))) < 4.0
    assert unknown_evidence(sweeps, fit.residual, fit.state) < 10.0
    assert residual_map(sweeps, noise, fit).regions == ()


def test_a_map_of_noise_is_one_on_the_mean_of_six_campaigns(toy, pool):
    maps = [residual_map(*fitted(toy, pool, seed=seed)) for seed in range(6)]
    assert np.mean([left.sigma**2 for left in maps]) == pytest.approx(1.0, abs=0.02)


def test_a_discrepancy_is_found_where_it_is(toy, pool):
    sweeps, noise, fit = fitted(toy, pool, extra=bump)
    assert min(whiteness(sweeps, fit.residual)) > 4.0
    excess = fit.total - fit.dof
    assert 0.5 * excess > unknown_evidence(sweeps, fit.residual, fit.state) > 0.3 * excess
    left = residual_map(sweeps, noise, fit)
    strongest = left.regions[0]
    assert strongest.frequency[0] < 640.0 < strongest.frequency[1]
    assert strongest.temperature[0] > 15.0
    assert sum(r.share for r in left.regions) > 0.8
    shares = left.shares()
    assert shares["channel"].keys() == {"S1", "S2"}
    for kind in ("channel", "frequency", "direction", "level"):
        total = sum(shares[kind].values()) + (
            shares["readings"]["temperature readings"] if kind in {"channel", "frequency"} else 0.0
        )
        assert total == pytest.approx(1.0)


def test_relative_misfit_is_that_of_the_lines(toy, pool):
    frf, _ = toy.record(temperatures=TEMPERATURES, extra=bump)
    sweeps, _, fit = fitted(toy, pool, extra=bump)
    used = ~frf.excluded
    twin = np.array([sweeps.nodes.at_lines(p) for p in fit.predicted])
    plain = np.linalg.norm(frf.h[:, :, used] - twin) / np.linalg.norm(frf.h[:, :, used])
    assert relative_misfit(sweeps, fit) == pytest.approx(plain, rel=0.01)
