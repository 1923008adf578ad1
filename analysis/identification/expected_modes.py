"""Sweeps fitted with the modes a twin expects: its frequencies and damping as priors, its numbers as labels.

One FRF of a lossy plate cannot tell all modes apart: two that overlap look like one between them, and its stated
deviation is that of noise alone. A twin knows how many modes there are and where, to some tenths of a per cent.
With them as priors every mode is fitted in every sweep, so that deviations hold what neighbours may hide, and no
mode can change its name from one temperature to the next.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.identification.automatic import Settings
from analysis.identification.averaging import averaged
from analysis.identification.held_fit import held_fit
from analysis.identification.measured import Measured
from analysis.identification.modes import Modes
from analysis.identification.parameters import to_parameters
from analysis.identification.pole_search import Prior, fit

BEYOND = 0.15
"""Share of the band's edges up to which modes outside it are fitted as well."""

FAR = 4.0
"""Standard deviations from its expected frequency from which a mode's number is in doubt."""

NOT_SHOWN = "the twin expects it here; this FRF alone would not show it"


@dataclass(frozen=True)
class ExpectedModes:
    """Poles of a twin at every sweep.

    Attributes
    ----------
    poles : (T, J) complex ndarray
        rad/s, upper half plane; a column is one mode at all temperatures.
    frequency_deviation, damping_deviation : float
        How well they are known, relative.
    """

    poles: NDArray[np.complex128]
    frequency_deviation: float = 3e-3
    damping_deviation: float = 0.1

    def __post_init__(self) -> None:
        if self.poles.ndim != 2 or not ((self.poles.real < 0.0) & (self.poles.imag > 0.0)).all():
            raise ValueError("expected poles must be (T, J), stable and in the upper half plane")
        for name in ("frequency_deviation", "damping_deviation"):
            if not 0.0 < getattr(self, name) < 1.0:
                raise ValueError(f"{name} {getattr(self, name):g}: above 0 and below 1 wanted")


def fit_expected(
    measured: Sequence[Measured],
    expected: ExpectedModes,
    settings: Settings,
    progress: Callable[[str, float], None] | None = None,
) -> tuple[tuple[Modes, ...], NDArray[np.int64]]:
    """Fit every sweep with the modes that are expected in it.

    Parameters
    ----------
    measured : sequence of Measured
        T sweeps.
    expected : ExpectedModes
        J modes at every sweep.
    settings : Settings
    progress : callable, optional
        Told the stage and the share done.

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
    table = np.full(expected.poles.shape, -1, dtype=np.int64)
    found = []
    for t, one in enumerate(measured):
        place = expected.poles[t].imag / (2.0 * np.pi)
        low, high = one.frequency[0], one.frequency[-1]
        columns = np.flatnonzero((place > low * (1.0 - BEYOND)) & (place < high * (1.0 + BEYOND)))
        modes, index = _one(one, expected.poles[t, columns], expected, settings)
        inside = (modes.poles[index].imag > 2.0 * np.pi * low) & (modes.poles[index].imag < 2.0 * np.pi * high)
        table[t, columns] = np.where(inside, index, -1)
        found.append(modes)
        if progress is not None:
            progress("identify", (t + 1) / len(measured))
    return tuple(found), table


def _one(
    measured: Measured, poles: NDArray[np.complex128], expected: ExpectedModes, settings: Settings
) -> tuple[Modes, NDArray[np.int64]]:
    """Fit one sweep; also where every expected pole stands among its modes."""
    terms = max(settings.terms, key=lambda one: one.parameters)
    place = to_parameters(poles)
    deviation = np.broadcast_to([expected.frequency_deviation, expected.damping_deviation], place.shape)
    lines = measured.lines()
    rough = fit(averaged(lines), poles, terms, tolerance=1e-3, prior=Prior(place, 0.5 * deviation**-2.0))
    alone = fit(lines, rough.poles, terms, max_iterations=0)
    modes, index, worth = held_fit(measured, alone, place, deviation, settings)
    status, reason = list(modes.status), list(modes.reason)
    away = np.exp(to_parameters(modes.poles[index])[:, 0] - place[:, 0]) - 1.0
    for n, gain, share in zip(index, worth, away, strict=True):
        if status[n] == "computational" and modes.band[0] <= modes.poles[n].imag / (2.0 * np.pi) <= modes.band[1]:
            status[n], reason[n] = "weak", f"known from the twin; alone here: {reason[n]}"
        elif gain < 0.0 and status[n] == "kept":
            status[n], reason[n] = "weak", NOT_SHOWN
        if status[n] in ("kept", "weak") and abs(share) > FAR * expected.frequency_deviation:
            told = f"{100 * share:+.1f} % from where the twin expects it: its number may be another mode's"
            status[n], reason[n] = "weak", told
    return replace(modes, status=tuple(status), reason=tuple(reason)), index
