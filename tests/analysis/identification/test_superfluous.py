"""Tracks that no mode needs go; modes that only all sweeps together tell apart stay."""

import numpy as np
import pytest

from analysis.identification.lines import Lines
from analysis.identification.over_temperature import sweep_fits
from analysis.identification.over_temperature.joint_fit import JointFit, fit_together
from analysis.identification.over_temperature.smooth_tracks import SmoothTracks
from analysis.identification.over_temperature.sweep_fits import remove_superfluous
from analysis.identification.pole_residue import COMPLEX_E_F, NONE, synthesis, to_parameters

FREQUENCY = np.arange(80.0, 620.0, 1.0)
TEMPERATURE = np.linspace(0.0, 60.0, 9)
AT_COLD = np.array([140.0, 250.0, 420.0, 436.0, 530.0])
RESIDUES = 1j * np.array([[90.0, -110.0, 140.0, 150.0, -120.0]])


def truth() -> np.ndarray:
    common = 1.0 - 0.3 * TEMPERATURE / 60.0
    return 2j * np.pi * AT_COLD * common[:, None] * np.sqrt(1 + 0.06j)


def fitted(extra: list[float], seed: int) -> tuple[list[Lines], SmoothTracks, JointFit]:
    """Fit of the five modes and of extra tracks, Hz at 0 °C."""
    rng = np.random.default_rng(seed)
    lines = []
    for poles in truth():
        h = synthesis(FREQUENCY, poles, RESIDUES, NONE, np.zeros((1, 0), complex))
        deviation = 0.01 * np.sqrt(np.mean(np.abs(h) ** 2))
        draw = rng.normal(size=h.shape) + 1j * rng.normal(size=h.shape)
        lines.append(Lines(FREQUENCY, h + deviation / np.sqrt(2) * draw, np.full(h.shape, deviation)))
    added = truth()[:, :1] * np.array(extra) / AT_COLD[0]
    place = np.stack([to_parameters(row) for row in np.concatenate([truth(), added], axis=1)])
    tracks = SmoothTracks.polynomials(TEMPERATURE, np.zeros_like(place))
    active = np.ones(place.shape[:2], dtype=bool)
    terms = [COMPLEX_E_F] * len(lines)
    return lines, tracks, fit_together(lines, terms, place, active, tracks, settled=20.0)


def left(extra: list[float], seed: int) -> np.ndarray:
    """Places at 0 °C, Hz, of the tracks that stay."""
    lines, tracks, found = fitted(extra, seed)
    now = remove_superfluous(lines, [COMPLEX_E_F] * len(lines), found, tracks, 20.0)
    assert (now.active == now.active[:1]).all()
    return np.sort(np.exp(now.place[0, now.active[0], 0]) / (2.0 * np.pi))


@pytest.mark.parametrize("extra", [[], [252.0], [330.0], [139.0, 533.0]])
@pytest.mark.parametrize("seed", [0, 1])
def test_what_no_mode_needs_goes_and_every_mode_stays(extra: list[float], seed: int) -> None:
    """A second track beside a mode, one in the noise, one beside either of two modes; 420 and 436 Hz are two."""
    expected = np.abs(2.0 * np.pi * AT_COLD * np.sqrt(1 + 0.06j)) / (2.0 * np.pi)
    np.testing.assert_allclose(left(extra, seed), expected, rtol=6e-3)


def test_a_track_that_no_sweep_needs_takes_part_in_none() -> None:
    lines, tracks, found = fitted([330.0], 0)
    now = remove_superfluous(lines, [COMPLEX_E_F] * len(lines), found, tracks, 20.0)
    assert not now.active[:, -1].any()
    assert all(len(projection.poles) == len(AT_COLD) for projection in now.projections)
    assert np.isfinite(now.place).all()


def test_what_surely_does_not_pay_goes_though_no_trial_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sweep_fits, "MOST_TRIALS", 0)
    assert len(left([330.0], 0)) == len(AT_COLD)
