"""FRFs that can be laid over those measured: held ones, and ones rebuilt where they are looked at."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real
from analysis.identification.over_temperature.tracked_modes import TrackedModes
from analysis.recordings.chosen_actuator import sweeps_of_modes
from analysis.recordings.frf import Frf
from app.view.nyquist import POINTS_OF_CIRCLE
from app.view.recorded.results import Results

UNMENTIONED_SHARE = 0.02
"""Share of lines outside an identified band that is not mentioned: mains lines at its ends are never fitted."""


@dataclass(frozen=True)
class Computed:
    """FRFs that are there: `h` (T, K, F) at `frequency` (F,), Hz."""

    frequency: Real
    h: Complex

    def __len__(self) -> int:
        """Sweeps."""
        return len(self.h)

    def sweep(self, row: int) -> Complex:
        """One sweep, (K, F)."""
        return np.asarray(self.h[row])

    def between(self, row: int, band: tuple[float, float]) -> Complex:
        """One sweep inside a band, Hz: (K, n)."""
        return np.asarray(self.h[row][:, (self.frequency >= band[0]) & (self.frequency <= band[1])])

    def line(self, rows: NDArray[np.intp], frequency: float) -> Complex:
        """Several sweeps at the nearest line, (R, K)."""
        return np.asarray(self.h[rows, :, int(np.abs(self.frequency - frequency).argmin())])


@dataclass(frozen=True)
class Identified:
    """FRFs rebuilt from poles and residues where they are looked at: all of a long campaign would take seconds.

    NaN outside the band that was identified, where they hold no longer.
    """

    frequency: Real
    modes: TrackedModes
    places: NDArray[np.int_]
    """Of every sweep among those of `modes`, -1 where it is none of them: there is nothing to draw."""

    def __len__(self) -> int:
        """Sweeps."""
        return len(self.places)

    def sweep(self, row: int) -> Complex:
        """One sweep, (K, F)."""
        return self._rebuilt(row, self.frequency)

    def between(self, row: int, band: tuple[float, float]) -> Complex:
        """One sweep inside a band, Hz, finer than its lines: (K, n)."""
        return self._rebuilt(row, np.linspace(*band, POINTS_OF_CIRCLE))

    def line(self, rows: NDArray[np.intp], frequency: float) -> Complex:
        """Several sweeps at one frequency, (R, K)."""
        return np.array([self._rebuilt(int(row), np.array([frequency]))[:, 0] for row in rows])

    def narrower(self, row: int) -> tuple[float, float] | None:
        """Band of a sweep that was identified, Hz, if more than a few lines at the ends are outside."""
        if self.places[row] < 0:
            return None
        low, high = self.modes.modes[int(self.places[row])].band
        return (
            (low, high) if ((self.frequency < low) | (self.frequency > high)).mean() > UNMENTIONED_SHARE else None
        )

    def _rebuilt(self, row: int, frequency: Real) -> Complex:
        if self.places[row] < 0:
            return np.full((len(self.modes.channels), len(frequency)), complex(np.nan, np.nan))
        modes = self.modes.modes[int(self.places[row])]
        inside = (frequency >= modes.band[0]) & (frequency <= modes.band[1])
        return np.where(inside, modes.synthesis(frequency), complex(np.nan, np.nan))


Answer = Identified | Computed


def answers(frf: Frf, results: Results) -> dict[str, Answer]:
    """All that may be laid over the FRFs measured, by name."""
    found: dict[str, Answer] = {}
    places = None if results.modes is None else sweeps_of_modes(frf, results.modes)
    if results.modes is not None and places is not None and (places >= 0).any():
        found["from poles and residues"] = Identified(frf.frequency, results.modes, places)
    for name, held in (("updated twin", results.updated), ("corrected twin", results.corrected)):
        if held is not None:
            found[name] = Computed(held[1].frequency, held[1].h)
    return {name: answer for name, answer in found.items() if len(answer) == len(frf.h)}
