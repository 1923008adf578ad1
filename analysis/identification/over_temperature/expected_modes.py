"""Sweeps fitted with the modes that a twin predicts: frequencies and damping as priors, mode numbers as labels.

One FRF of a lossy plate cannot separate all modes: two that overlap look like one between them, whose standard
deviation covers noise alone. A twin predicts the number of modes and their frequencies to some tenths of a per
cent. With these as priors every mode is fitted in every sweep, so that standard deviations include the effect of
overlapping neighbours, and a mode keeps its number at all temperatures.

Of damping a twin knows the material's share alone: supports, joints, cables and air damp each mode in their own
way. How far the modes' damping scatters about the twin's is learned from the sweeps (empirical Bayes): a prior of
that width helps modes that hide each other, and pulls none that the sweeps show.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.identification.measured import Measured
from analysis.identification.modes import Modes
from analysis.identification.over_temperature.smooth_tracks import OWN_DAMPING, WIDE, SmoothTracks
from analysis.identification.over_temperature.sweep_fits import fit_sweeps
from analysis.identification.pole_residue import active_in, to_parameters
from analysis.identification.settings import Settings

EXPECTED_BAND_MARGIN = 0.3
"""See `parameters.BAND_MARGIN`; expected modes need no evidence of their own, so that more of them can be fitted.
With 0.15 a mode 15 % above the band of a disc was left out, and all loss factors were 10 % too high."""

DOUBTFUL_DISTANCE = 4.0
"""Standard deviations from the expected frequency beyond which a mode's number is doubtful."""


@dataclass(frozen=True)
class ExpectedModes:
    """Poles of a twin at every sweep.

    Attributes
    ----------
    poles : (T, J) complex ndarray
        rad/s, upper half plane; a column is one mode at all temperatures.
    frequency_deviation : float
        Relative standard deviation of each mode's own error, without the part common to all modes of a sweep.
    damping_deviation : float or None
        The same of the damping ratio; None to learn it from the sweeps.
    """

    poles: NDArray[np.complex128]
    frequency_deviation: float = 3e-3
    damping_deviation: float | None = None

    def __post_init__(self) -> None:
        if self.poles.ndim != 2 or not ((self.poles.real < 0.0) & (self.poles.imag > 0.0)).all():
            raise ValueError("expected poles must be (T, J), stable and in the upper half plane")
        for name in ("frequency_deviation", "damping_deviation"):
            value = getattr(self, name)
            if value is not None and not 0.0 < value < 1.0:
                raise ValueError(f"{name} {value:g}: above 0 and below 1 wanted")


def fit_expected(
    temperature: NDArray[np.float64],
    measured: Sequence[Measured],
    expected: ExpectedModes,
    settings: Settings,
    progress: Callable[[str, float], None] | None = None,
) -> tuple[tuple[Modes, ...], NDArray[np.int64]]:
    """Fit every sweep with the modes expected in it.

    Parameters
    ----------
    temperature : (T,) ndarray
        Degrees Celsius.
    measured : sequence of Measured
        T sweeps.
    expected : ExpectedModes
        J modes at every sweep.
    progress : callable, optional
        Called with the stage and the share done.

    Returns
    -------
    modes : tuple of Modes
        One per sweep.
    table : (T, J) ndarray of int
        Place of each expected mode's pole in the sweep's modes; -1 out of band.

    Raises
    ------
    ValueError
        Where sweeps and expected poles differ in number.
    """
    if len(expected.poles) != len(measured):
        raise ValueError(
            f"expected poles are given for {len(expected.poles)} sweeps, {len(measured)} were measured"
        )
    whole = np.stack([to_parameters(row) for row in expected.poles])
    active = np.stack(
        [active_in(row, one.frequency, EXPECTED_BAND_MARGIN) for row, one in zip(whole, measured, strict=True)]
    )
    known = active.any(axis=0)
    base = whole[:, known]
    own = (expected.frequency_deviation, expected.frequency_deviation / 3.0)
    given = expected.damping_deviation
    damping = WIDE if given is None else (given, given * OWN_DAMPING[1] / OWN_DAMPING[0])
    tracks = SmoothTracks.polynomials(temperature, base, own, damping, 1)
    terms = [max(settings.terms, key=lambda one: one.parameters)] * len(measured)
    found, index, *_ = fit_sweeps(
        measured, terms, base, active[:, known], tracks, settings, progress, learn_damping=given is None
    )
    table = np.full(expected.poles.shape, -1, dtype=np.int64)
    table[:, known] = index
    departure = np.full(expected.poles.shape, np.nan)
    for t, modes in enumerate(found):
        there = table[t] >= 0
        departure[t, there] = np.abs(modes.poles[table[t, there]]) / np.abs(expected.poles[t, there]) - 1.0
    checked = (
        _weak_where_doubtful(modes, row, away, expected)
        for modes, row, away in zip(found, table, departure, strict=True)
    )
    return tuple(checked), table


def _weak_where_doubtful(
    modes: Modes, index: NDArray[np.int64], departure: NDArray[np.float64], expected: ExpectedModes
) -> Modes:
    """Set modes to weak that only the twin determines, or whose number is doubtful."""
    status, reason = list(modes.status), list(modes.reason)
    for j in np.flatnonzero(index >= 0):
        n = index[j]
        if status[n] == "computational":
            status[n], reason[n] = "weak", f"determined by the twin only; from this sweep alone: {reason[n]}"
        if status[n] in ("kept", "weak") and abs(departure[j]) > DOUBTFUL_DISTANCE * expected.frequency_deviation:
            doubt = f"{100 * departure[j]:+.1f} % from where the twin expects it: its number may be another mode's"
            status[n], reason[n] = "weak", doubt
    return replace(modes, status=tuple(status), reason=tuple(reason))
