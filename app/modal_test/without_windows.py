"""What windows do to the modes of a test, taken out of them and put back for comparison with the measured FRFs."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analysis.estimation.estimators import Segments
from analysis.estimation.windows import without_window
from analysis.identification.judgement.leakage import Unleaked, seen_through, without_leakage
from analysis.identification.judgement.status import WEAK_DAMPING
from analysis.identification.measured import Measured
from analysis.identification.modes import Modes
from app.modal_test.frf_set import FrfSet

UNSURE = "without the window's its damping ratio is known to {:.0f} % only"
LEAKS = "after the leakage of its segments its damping ratio is known to {:.0f} % only"
DROWNED = "the exponential window drowned its damping: record longer blocks with a weaker window"


def rebuilt(modes: Modes, frequency: NDArray[np.float64], frfs: FrfSet) -> NDArray[np.complex128]:
    """FRFs that the modes make under the windows of a test.

    Parameters
    ----------
    modes : Modes
        Damping by windows taken out.
    frequency : (F,) ndarray
        Hz.
    frfs : FrfSet
        Says which windows.

    Returns
    -------
    (L, F) complex ndarray
        In the units of the residues.
    """
    if frfs.segments is not None:
        return seen_through(frfs.segments, modes, frequency)
    return replace(modes, poles=modes.poles - frfs.window_rate).synthesis(frequency)


def without_windows(frfs: FrfSet, modes: Modes) -> tuple[FrfSet, Modes]:
    """Take the damping by an exponential window or by the window of segments out of modes.

    Parameters
    ----------
    modes : Modes
        As fitted to them.

    Returns
    -------
    frfs : FrfSet
        With notes; without segments if these cannot be taken out.
    modes : Modes
    """
    if frfs.segments is None or frfs.variance is None or not modes.real.any():
        return replace(frfs, segments=None), freed(modes, frfs.window_rate)
    lines = Measured(frfs.frequency, frfs.h, frfs.variance).without(modes.left_out(frfs.frequency)).lines()
    found = without_leakage(modes, lines, frfs.segments)
    notes = (*frfs.notes, *_widened(modes, found, frfs.segments))
    if found.corrected:
        return replace(frfs, notes=notes), found.modes
    known = np.sqrt(found.modes.covariance[:, 1, 1])
    words = [LEAKS.format(100 * k) if k > WEAK_DAMPING else "" for k in known]
    return replace(frfs, notes=notes, segments=None), _weakened(found.modes, words)


def _widened(modes: Modes, found: Unleaked, segments: Segments) -> list[str]:
    """Name the modes that the window moves by more than their σ, and how long segments would have to be."""
    deviation = np.sqrt(np.diagonal(modes.covariance, axis1=1, axis2=2))
    size = (np.abs(found.bias) / np.where(deviation > 0.0, deviation, np.inf)).max(axis=1)
    moved = np.flatnonzero(modes.real & (size > 1.0))
    if not len(moved):
        return []
    f = np.abs(modes.poles) / (2.0 * np.pi)
    named = ", ".join(f"{f[j]:.1f} Hz (damping by {100 * np.expm1(found.bias[j, 1]):.2g} %)" for j in moved)
    # leakage falls with the square of the length if the window begins and ends at zero
    power = 1.0 if segments.window == "rectangular" else 0.5
    needed = segments.seconds * float(size[moved].max()) ** power
    remedy = "is corrected" if found.corrected else "could not be corrected and is in their σ"
    return [
        f"segments of {segments.seconds:g} s widen modes by more than their σ: {named}. This {remedy}; with "
        f"segments.seconds = {needed:.2g}, and the recording longer by as much, it would be below σ"
    ]


def freed(modes: Modes, rate: float) -> Modes:
    """Take an exponential window's damping out of the poles; those are called weak whose own is then not known."""
    if not rate:
        return modes
    poles, spread = without_window(modes.poles, modes.covariance, rate)
    drowned = modes.poles.real + rate > 1e-3 * modes.poles.real
    known = np.sqrt(spread[:, 1, 1])
    words = [
        DROWNED if d else UNSURE.format(100 * k) if k > WEAK_DAMPING else ""
        for d, k in zip(drowned, known, strict=True)
    ]
    return _weakened(replace(modes, poles=poles, covariance=spread), words)


def _weakened(modes: Modes, words: list[str]) -> Modes:
    """Call modes weak that have a word on them, and add it to their reasons."""
    return replace(
        modes,
        status=tuple("weak" if w and s == "kept" else s for w, s in zip(words, modes.status, strict=True)),
        reason=tuple(f"{r}; {w}" if w else r for w, r in zip(words, modes.reason, strict=True)),
    )
