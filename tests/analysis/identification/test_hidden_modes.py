"""Modes that no sweep shows alone are found by all together, and none is found that is not there."""

from functools import cache

import numpy as np
import pytest

from analysis.identification.lines import Lines
from analysis.identification.over_temperature.joint_fit import JointFit, fit_together
from analysis.identification.over_temperature.smooth_tracks import SmoothTracks
from analysis.identification.over_temperature.sweep_fits import HiddenModes, add_hidden_modes, find_hidden_modes
from analysis.identification.pole_residue import COMPLEX_E_F, NONE, synthesis, to_parameters

FREQUENCY = np.arange(80.0, 620.0, 1.5)
TEMPERATURE = np.linspace(0.0, 60.0, 9)
AT_COLD = np.array([140.0, 250.0, 420.0, 427.0, 530.0])
RESIDUES = 1j * np.array([90.0, -110.0, 140.0, 60.0, -120.0])


def fitted(modes: list[int], seed: int, responses: int = 1) -> tuple[list[Lines], SmoothTracks, JointFit]:
    """Fit of some of the five modes to sweeps that hold all."""
    rng = np.random.default_rng(seed)
    lines, place = [], []
    for stretch in 1.0 - 0.3 * TEMPERATURE / 60.0:
        poles = 2j * np.pi * AT_COLD * stretch * np.sqrt(1 + 0.06j)
        residues = RESIDUES * (1.0 + 0.3 * np.sin(np.outer(np.arange(responses), 1.0 + np.arange(5))))
        h = synthesis(FREQUENCY, poles, residues / stretch, NONE, np.zeros((responses, 0), complex))
        deviation = 0.004 * np.sqrt(np.mean(np.abs(h) ** 2))
        draw = rng.normal(size=h.shape) + 1j * rng.normal(size=h.shape)
        lines.append(Lines(FREQUENCY, h + deviation / np.sqrt(2) * draw, np.full(h.shape, deviation)))
        place.append(to_parameters(poles[modes]))
    start = np.stack(place)
    tracks = SmoothTracks.polynomials(TEMPERATURE, np.zeros_like(start))
    active = np.ones(start.shape[:2], dtype=bool)
    return lines, tracks, fit_together(lines, [COMPLEX_E_F] * 9, start, active, tracks)


def at_cold(found: JointFit) -> np.ndarray:
    return np.sort(np.exp(found.place[0, found.active[0], 0]) / (2.0 * np.pi))


EVERY = np.ones(len(TEMPERATURE), dtype=bool)
EXPECTED = AT_COLD * abs(np.sqrt(1 + 0.06j))


@pytest.mark.parametrize("responses", [1, 2])
@pytest.mark.parametrize("seed", [0, 1])
def test_a_mode_that_its_neighbour_hides_is_added(seed: int, responses: int) -> None:
    lines, tracks, found = fitted([0, 1, 2, 4], seed, responses)
    more = add_hidden_modes(lines, [COMPLEX_E_F] * 9, found, tracks, EVERY)
    np.testing.assert_allclose(at_cold(more), EXPECTED, rtol=6e-3)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_none_is_added_that_is_not_there(seed: int) -> None:
    lines, tracks, found = fitted([0, 1, 2, 3, 4], seed)
    more = add_hidden_modes(lines, [COMPLEX_E_F] * 9, found, tracks, EVERY)
    assert np.array_equal(more.place, found.place)


@cache
def searched(modes: tuple[int, ...], seed: int) -> tuple[list[Lines], SmoothTracks, JointFit, HiddenModes]:
    lines, tracks, found = fitted(list(modes), seed)
    return lines, tracks, found, find_hidden_modes(lines, [COMPLEX_E_F] * 9, found, tracks, EVERY)


def widening(found: JointFit, hidden: HiddenModes) -> np.ndarray:
    """Variance of every frequency with hidden modes, in that without: (T, J)."""
    ratio: np.ndarray = 1.0 + hidden.spread[:, :, 0, 0] / found.covariance[:, :, 0, 0]
    return ratio


def test_deviations_widen_where_a_mode_is_hidden() -> None:
    _, _, found, hidden = searched((0, 1, 2, 4), 0)
    assert (widening(found, hidden)[:, 2] > 10.0).all()
    assert (np.linalg.eigvalsh(hidden.spread) > -1e-12 * hidden.spread.max()).all()


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_deviations_hardly_widen_where_none_is(seed: int) -> None:
    _, _, found, hidden = searched((0, 1, 2, 3, 4), seed)
    assert (widening(found, hidden) < 4.0).all()
    assert np.median(widening(found, hidden)) < 1.2


def test_sweeps_whose_residual_is_something_else_are_not_asked() -> None:
    lines, tracks, found, _ = searched((0, 1, 2, 4), 0)
    hidden = find_hidden_modes(lines, [COMPLEX_E_F] * 9, found, tracks, ~EVERY)
    assert not hidden.active.any()
    assert not hidden.gain.any()
    assert not hidden.spread.any()


def test_gain_is_the_fall_that_a_fit_finds() -> None:
    """Poles do not step out of their linear reach for it: the fit finds as much again at most by free residues."""
    lines, tracks, found, hidden = searched((0, 1, 2, 4), 0)
    best = hidden.place[:, [int(np.argmax(hidden.gain))]]
    assert np.exp(best[0, 0, 0]) / (2.0 * np.pi) == pytest.approx(427.0, rel=0.03)
    wide = tracks.one_more()
    place = np.concatenate([found.place, best], axis=1)
    free = fit_together(lines, [COMPLEX_E_F] * 9, place, np.ones((9, 5), dtype=bool), wide)
    fall = sum(2.0 * (a.misfit - b.misfit) for a, b in zip(found.projections, free.projections, strict=True))
    assert 0.5 < hidden.gain.max() / fall < 2.0
