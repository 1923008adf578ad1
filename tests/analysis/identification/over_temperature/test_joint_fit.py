"""Eight modes, three of them one peak, over a damping peak: what no sweep tells alone, all tell together."""

import numpy as np
import pytest

from analysis.identification.lines import Lines
from analysis.identification.over_temperature.joint_fit import JointFit, fit_together
from analysis.identification.over_temperature.smooth_tracks import SmoothTracks
from analysis.identification.pole_residue import COMPLEX_E_F, NONE, synthesis, to_parameters, to_poles
from analysis.identification.pole_search import fit

FREQUENCY = np.arange(80.0, 700.0, 1.0)
TEMPERATURE = np.linspace(0.0, 60.0, 13)
AT_COLD = np.array([140.0, 215.0, 300.0, 420.0, 428.0, 437.0, 520.0, 630.0])
RESIDUES = 1j * np.array([[90.0, -110.0, 150.0, 140.0, 160.0, -120.0, 170.0, 150.0]])


def truth() -> np.ndarray:
    """Poles (T, J): a common fall by a third, slopes of each mode's own, loss factors of 3 to 9 %."""
    common = 1.0 - 0.33 / (1.0 + np.exp(-(TEMPERATURE - 25.0) / 9.0))
    own = np.exp(np.outer(TEMPERATURE / 60.0, [0.0, 0.01, -0.01, 0.012, 0.0, -0.012, 0.005, 0.0]))
    eta = 0.03 + 0.06 * np.exp(-(((TEMPERATURE - 25.0) / 12.0) ** 2))
    return 2j * np.pi * AT_COLD * common[:, None] * own * np.sqrt(1 + 1j * eta[:, None])


def sweeps(seed: int, share: float = 0.005) -> list[Lines]:
    rng = np.random.default_rng(seed)
    found = []
    for poles in truth():
        h = synthesis(FREQUENCY, poles, RESIDUES, NONE, np.zeros((1, 0), complex))
        deviation = share * np.sqrt(np.mean(np.abs(h) ** 2))
        draw = rng.normal(size=h.shape) + 1j * rng.normal(size=h.shape)
        found.append(Lines(FREQUENCY, h + deviation / np.sqrt(2) * draw, np.full(h.shape, deviation)))
    return found


def together(seed: int) -> JointFit:
    """Start 0.1 % off, damping 5 %."""
    rng = np.random.default_rng(100 + seed)
    x = np.stack([to_parameters(row) for row in truth()])
    start = x + np.array([1e-3, 0.05]) * rng.normal(size=(1, len(AT_COLD), 2))
    tracks = SmoothTracks.polynomials(TEMPERATURE, np.zeros_like(x))
    return fit_together(sweeps(seed), [COMPLEX_E_F] * 13, start, np.ones(x.shape[:2], bool), tracks)


def test_three_modes_of_one_peak_are_told_apart_where_a_sweep_alone_cannot() -> None:
    """At the damping peak the middle one of the three is wrong four times as far in a fit of that sweep alone."""
    hot = 5
    x = np.stack([to_parameters(row) for row in truth()])
    alone = np.mean(
        [
            np.abs(
                to_parameters(fit(sweeps(seed)[hot], truth()[hot] * 1.003, COMPLEX_E_F).poles)[4, 0] - x[hot, 4, 0]
            )
            for seed in range(3)
        ]
    )
    joint = np.mean([np.abs(together(seed).place[hot, 4, 0] - x[hot, 4, 0]) for seed in range(3)])
    assert joint < 1e-3
    assert alone > 4.0 * joint


def test_deviations_of_the_posterior_hold_the_truth() -> None:
    """Of 4 draws of 13 sweeps, nine in ten poles lie within two deviations, which are no wider than need be."""
    x = np.stack([to_parameters(row) for row in truth()])
    away = []
    for seed in range(4):
        found = together(seed)
        away.append((found.place - x) / np.sqrt(np.diagonal(found.covariance, axis1=2, axis2=3)))
    assert np.mean(np.abs(away) < 1.96, axis=(0, 1, 2)).min() > 0.88
    assert np.mean(np.square(away)) > 0.3


def test_a_sweep_that_does_not_take_part_is_placed_by_the_others() -> None:
    x = np.stack([to_parameters(row) for row in truth()])
    active = np.ones(x.shape[:2], bool)
    active[6, 3] = False
    h = [lines.h.copy() for lines in sweeps(1)]
    pole, residue = truth()[6, 3:4], RESIDUES[:, 3:4]
    h[6] = h[6] - synthesis(FREQUENCY, pole, residue, NONE, np.zeros((1, 0), complex))
    lines = [Lines(FREQUENCY, own, one.deviation) for own, one in zip(h, sweeps(1), strict=True)]
    tracks = SmoothTracks.polynomials(TEMPERATURE, np.zeros_like(x))
    found = fit_together(lines, [COMPLEX_E_F] * 13, x, active, tracks)
    error = np.abs(found.place[6, 3] - x[6, 3])
    assert error[0] < 4.0 * np.sqrt(found.covariance[6, 3, 0, 0])
    assert error[0] < 3e-3


def test_without_a_prior_one_sweep_is_what_it_is_alone() -> None:
    """One sweep, tracks that hold nothing: the poles and covariance of the plain search."""
    lines = sweeps(2)[0]
    start = np.stack([to_parameters(truth()[0])])
    tracks = SmoothTracks.polynomials(TEMPERATURE[:1], np.zeros_like(start), damping=(1e3, 1e3))
    found = fit_together([lines], [COMPLEX_E_F], start, np.ones((1, 8), bool), tracks, settled=1e-6)
    plain = fit(lines, truth()[0], COMPLEX_E_F, tolerance=1e-12)
    spread = np.sqrt(np.diag(0.5 * np.linalg.inv(plain.projection.hessian))).reshape(-1, 2)
    np.testing.assert_array_less(np.abs(found.place[0] - to_parameters(plain.poles)), 0.02 * spread)
    np.testing.assert_allclose(np.sqrt(np.diagonal(found.covariance[0], axis1=1, axis2=2)), spread, rtol=0.05)
    assert to_poles(found.place[0]) == pytest.approx(plain.poles, rel=1e-3)
