"""Sweeps on a ramp, each line measured at its own temperature, against the laws put in."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from analysis.experiment import Protocol
from analysis.material import Material, laws_through
from analysis.recordings.frf import Frf
from analysis.updating.drift import sweep_laws, to_first_order
from analysis.updating.laws import fit_laws
from analysis.updating.update import update

GAIN = 14.0
T = np.linspace(-10.0, 70.0, 9)
LAWS = laws_through(T, Material(3.0e9 * np.exp(-0.018 * T), 0.35 + 0.001 * T, 0.05 * np.exp(-0.003 * T)))
TEMPERATURE = np.linspace(0.0, 60.0, 13)
PROTOCOL = Protocol(
    sweep="logarithmic", band=(100.0, 1500.0), sweep_duration=10.0, taper=0.5, tail=1.0, repeats=2,
    ramp_rate=1.0, temperatures=tuple(TEMPERATURE), directions=("up",), levels=(1.0,),
)  # fmt: skip


def recorded(twin, protocol: Protocol) -> Frf:
    """One sweep at each temperature, with noise of 0.3 % and each line at the temperature when it was swept."""
    rows = LAWS.at(TEMPERATURE)
    constants = zip(rows.youngs_modulus, rows.poisson_ratio, rows.loss_factor, strict=True)
    still = twin.measured(TEMPERATURE, constants, GAIN, np.random.default_rng(5), 0.003)
    assert protocol.timing is not None
    away = protocol.ramp_rate / 60.0 * protocol.timing.after_middle(still.frequency)
    nodes = np.linspace(away.min(), away.max(), 5)
    drifted = []
    for t in TEMPERATURE:
        at_nodes = [twin.frf(LAWS.local(t + a), still.frequency)[0] for a in nodes]
        drifted.append(
            np.diagonal(CubicSpline(nodes, at_nodes)(away)) - twin.frf(LAWS.local(t), still.frequency)[0]
        )
    return replace(still, h=still.h + GAIN * np.array(drifted)[:, None])


def test_laws_put_in_are_found_from_drifting_sweeps(twin) -> None:
    frf, true = recorded(twin, PROTOCOL), LAWS.at(TEMPERATURE)
    steady, found = update(frf, twin), update(frf, twin, protocol=PROTOCOL)

    def off(one: Material) -> tuple[float, float]:
        e = np.abs(one.youngs_modulus / true.youngs_modulus - 1.0).max()
        return float(e), float(np.abs(one.poisson_ratio - true.poisson_ratio).max())

    assert steady.chi2_per_dof.min() > 2.0
    np.testing.assert_allclose(found.chi2_per_dof, 1.0, atol=0.2)
    assert off(found.material)[0] < 0.3 * off(steady.material)[0]
    assert off(found.material)[1] < 0.3 * off(steady.material)[1]


def averaged(twin, protocol: Protocol) -> Frf:
    """One sweep at each temperature, the mean over repeats that follow each other on the ramp."""
    rows = LAWS.at(TEMPERATURE)
    constants = zip(rows.youngs_modulus, rows.poisson_ratio, rows.loss_factor, strict=True)
    still = twin.measured(TEMPERATURE, constants, GAIN, np.random.default_rng(5), 0.0005)
    place = np.arange(protocol.repeats) - 0.5 * (protocol.repeats - 1)
    away = protocol.ramp_rate / 60.0 * protocol.record * place
    mean = [
        np.mean([twin.frf(LAWS.local(t + a), still.frequency) for a in away], axis=0)
        - twin.frf(LAWS.local(t), still.frequency)
        for t in TEMPERATURE
    ]
    return replace(still, h=still.h + GAIN * np.array(mean))


def test_a_mean_over_repeats_on_a_ramp_does_not_look_like_damping(twin) -> None:
    protocol = PROTOCOL.model_copy(update={"taper": None, "repeats": 3})
    frf, true = averaged(twin, protocol), LAWS.at(TEMPERATURE)
    first = update(frf, twin)
    with ThreadPoolExecutor(2) as executor:
        laws = fit_laws(TEMPERATURE, first.material, first.sigma, temperature_range=(0.0, 60.0))
        local = sweep_laws(TEMPERATURE, first.material, laws)
        corrected = to_first_order(frf, twin, local, first.gains, protocol, executor)
        straight = sweep_laws(TEMPERATURE, first.material, None)
        assert to_first_order(frf, twin, straight, first.gains, protocol, executor) is frf
        slow = protocol.model_copy(update={"ramp_rate": 0.05})
        assert to_first_order(frf, twin, local, first.gains, slow, executor) is frf
    found = update(corrected, twin)
    before, after = (float(np.mean(u.material.loss_factor / true.loss_factor - 1.0)) for u in (first, found))
    assert before > 1e-3
    assert abs(after) < 0.1 * before


def test_nothing_is_known_of_the_drift_without_taper_or_ramp(twin) -> None:
    frf = recorded(twin, PROTOCOL)
    steady = update(frf, twin)
    for change in ({"taper": None, "repeats": 1}, {"ramp_rate": 0.0}):
        known = update(frf, twin, protocol=PROTOCOL.model_copy(update=change))
        np.testing.assert_array_equal(known.material.youngs_modulus, steady.material.youngs_modulus)


def test_laws_of_a_sweep_go_through_its_own_material_with_the_slopes_of_all(twin) -> None:
    updated = update(recorded(twin, PROTOCOL), twin)
    laws = sweep_laws(TEMPERATURE, updated.material, LAWS)
    for law, e, t in zip(laws, updated.material.youngs_modulus, TEMPERATURE, strict=True):
        assert law.youngs_modulus(t) == pytest.approx(e)
        assert law.rates(t) == pytest.approx(LAWS.local(t).slope)
    assert all(not law.slope.any() for law in sweep_laws(TEMPERATURE, updated.material, None))
