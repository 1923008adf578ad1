"""Many FRFs with common poles: as many modes as few of them show, in the time of few."""

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.identification.automatic import identify
from analysis.identification.judgement.confirmation import confirmed
from analysis.identification.measured import MANY, PRINCIPAL_FRFS, Measured, principal_frfs
from analysis.identification.modes import Modes
from analysis.identification.pole_residue import REAL_E_F, synthesis
from analysis.identification.settings import Settings

SPACING = 0.25
SENSORS = 3
FREE = Settings(mains=None)


def roving_hammer(hits: int, moved: float, modes: int = 9) -> tuple[Measured, NDArray[np.complex128]]:
    """FRFs of every hit at three sensors; `moved`: lines by which peaks in the middle shift between hits."""
    rng = np.random.default_rng(5)
    f = np.arange(30.0, 230.0, SPACING)
    own = np.linspace(42.0, 215.0, modes) + rng.uniform(-6.0, 6.0, modes)
    poles = 2 * np.pi * own * (-rng.uniform(0.003, 0.008, modes) + 1j)
    shapes, size = rng.standard_normal((hits, modes)), 10 ** rng.uniform(-0.6, 0.3, modes)
    at_sensors = rng.standard_normal((SENSORS, modes))
    shift = 1.0 + moved * SPACING / f.mean() * rng.standard_normal(hits)
    rows = [
        synthesis(f, poles * shift[hit], -1j * (shapes[hit] * at * size)[None], REAL_E_F, np.array([[0.002, 0.0]]))
        for hit in range(hits)
        for at in at_sensors
    ]
    h = np.concatenate(rows)
    noise = rng.standard_normal(h.shape) + 1j * rng.standard_normal(h.shape)
    h = h + 0.03 * np.sqrt((np.abs(h) ** 2).mean(axis=1, keepdims=True)) * noise
    return Measured(f, h), poles


def found_of(modes: Modes, poles: NDArray[np.complex128]) -> int:
    own = modes.poles[modes.real]
    return sum(bool(np.abs(own - pole).min() < -pole.real) for pole in poles)


def test_sums_have_the_poles_of_the_frfs() -> None:
    measured, poles = roving_hammer(20, 0.0)
    sums = principal_frfs(measured)
    assert sums.measured.h.shape == (PRINCIPAL_FRFS, len(measured.frequency))
    np.testing.assert_allclose(sums.measured.h, sums.factors @ measured.h)
    few = identify(sums.measured, FREE)
    assert found_of(few, poles) == len(poles) == few.real.sum()


def test_modes_of_sums_rebuild_the_sums() -> None:
    measured, _ = roving_hammer(12, 0.0)
    assert len(measured.h) > MANY
    modes = identify(measured, FREE)
    sums = principal_frfs(measured)
    rebuilt = sums.modes(modes).synthesis(measured.frequency)
    np.testing.assert_allclose(rebuilt, sums.factors @ modes.synthesis(measured.frequency), rtol=1e-9)


def test_every_frf_has_its_residues() -> None:
    measured, _ = roving_hammer(20, 0.0)
    modes = identify(measured, FREE)
    assert modes.residues.shape == (60, len(modes.poles))
    assert modes.misfit < 0.06  # noise of 3 % in both parts


@pytest.mark.slow
@pytest.mark.parametrize("hits", [12, 40])
def test_peaks_that_move_between_hits_hide_no_mode(hits: int) -> None:
    """A pole for all FRFs costs a residue in each: with forty hits, BIC on all of them gave up modes of twelve."""
    measured, poles = roving_hammer(hits, 0.7)
    modes = confirmed(measured, identify(measured, FREE))
    assert found_of(modes, poles) == len(poles)
    assert modes.sure.sum() >= len(poles) - 1


def test_coherences_that_promise_too_much_hide_no_mode() -> None:
    measured, poles = roving_hammer(20, 0.7)
    variance = np.abs(measured.h) ** 2 * (1 - 0.998) / (2 * 3 * 0.998)
    modes = identify(Measured(measured.frequency, measured.h, variance), FREE)
    assert found_of(modes, poles) == len(poles)
