"""Modes that one hit of several shows, beside modes that all show."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.identification.automatic import identify
from analysis.identification.judgement.confirmation import WithoutHit, confirmed, confirmed_by_hits
from analysis.identification.measured import Measured
from analysis.identification.modes import Modes
from analysis.identification.settings import Settings

LINES = np.arange(50.0, 350.0, 0.5)
FREQUENCIES, DAMPING = np.array([80.0, 131.0, 190.0, 262.0, 301.0]), 0.008
FALSE = 225.0
ROWS = 4
Frfs = NDArray[np.complex128]


def of_poles(frequencies: NDArray[np.float64], amplitudes: NDArray[np.float64]) -> Frfs:
    """Accelerances (K, F) of real modes, amplitudes (K, J) at the peaks."""
    w, w0 = 2 * np.pi * LINES, 2 * np.pi * frequencies[:, None]
    modal = -(w**2) / (w0**2 - w**2 + 2j * DAMPING * w0 * w) * 2 * DAMPING
    return np.asarray(amplitudes @ modal)


def five_hits(seed: int, false_at: int | None = None, size: float = 0.6) -> tuple[Measured, list[WithoutHit]]:
    """H1 of five hits of different power, 2 % noise in each response; one hit perhaps with a pole of its own."""
    rng = np.random.default_rng(seed)
    amplitudes = rng.uniform(0.3, 1.0, (ROWS, len(FREQUENCIES))) * rng.choice([-1, 1], (ROWS, len(FREQUENCIES)))
    power = rng.uniform(0.5, 2.0, 5)
    hits = []
    for hit in range(5):
        noise = rng.standard_normal((2, ROWS, LINES.size))
        h = of_poles(FREQUENCIES, amplitudes) + 0.02 / np.sqrt(2 * power[hit]) * (noise[0] + 1j * noise[1])
        if hit == false_at:
            h += of_poles(np.array([FALSE]), size * rng.choice([-1.0, 1.0], (ROWS, 1)))
        hits.append(h)

    def averaged(which: list[int]) -> Frfs:
        return np.asarray(np.average([hits[n] for n in which], axis=0, weights=power[which]))

    every = list(range(5))
    variance = np.full((ROWS, LINES.size), 0.02**2 / power.sum())
    without = [
        WithoutHit(f"hit {n + 1}", averaged([k for k in every if k != n]), 1.0 - float(power[n] / power.sum()))
        for n in every
    ]
    return Measured(LINES, averaged(every), variance), without


def identified(measured: Measured) -> Modes:
    return confirmed(measured, identify(measured, Settings()))


def at(modes: Modes, frequency: float) -> int:
    return int(np.abs(np.abs(modes.poles) / (2 * np.pi) - frequency).argmin())


@pytest.mark.parametrize("hit", [0, 3])
def test_a_mode_of_one_hit_is_unconfirmed_and_the_hit_is_named(hit: int) -> None:
    measured, without = five_hits(hit, hit)
    modes = identified(measured)
    false = at(modes, FALSE)
    assert np.abs(modes.poles[false]) / (2 * np.pi) == pytest.approx(FALSE, rel=5e-3)
    assert modes.confirmation[false] == "confirmed"  # by every part of the averages: they cannot tell
    found = confirmed_by_hits(measured, without, modes)
    assert found.confirmation[false] == "unconfirmed"
    assert f"rests on hit {hit + 1} alone" in found.reason[false]
    for frequency in FREQUENCIES:
        assert found.confirmation[at(found, frequency)] == "confirmed"
    np.testing.assert_array_equal(found.poles, modes.poles)


@pytest.mark.parametrize("seed", range(3))
def test_modes_that_all_hits_show_stay_as_they_are(seed: int) -> None:
    measured, without = five_hits(100 + seed)
    modes = identified(measured)
    assert confirmed_by_hits(measured, without, modes) == modes


def test_of_two_hits_nobody_knows_which_is_right() -> None:
    measured, without = five_hits(0, 0)
    modes = identified(measured)
    assert confirmed_by_hits(measured, without[:2], modes) is modes
    unjudged = replace(modes, confirmation=())
    assert "unconfirmed" in confirmed_by_hits(measured, without, unjudged).confirmation
