"""FRFs that can be laid over those measured: held ones, and ones rebuilt where they are looked at."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real
from analysis.identification.tracked_modes import TrackedModes


def decibels(h: Complex) -> Real:
    """20 log10 |h|, with a floor far below any measurement."""
    return np.asarray(20.0 * np.log10(np.abs(h) + 1e-20))


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

    def line(self, rows: NDArray[np.intp], frequency: float) -> Complex:
        """Several sweeps at the nearest line, (R, K)."""
        return np.asarray(self.h[rows, :, int(np.abs(self.frequency - frequency).argmin())])


@dataclass(frozen=True)
class Identified:
    """FRFs rebuilt from poles and residues where they are looked at: all of a long campaign would take seconds."""

    frequency: Real
    modes: TrackedModes

    def __len__(self) -> int:
        """Sweeps."""
        return len(self.modes.modes)

    def sweep(self, row: int) -> Complex:
        """One sweep, (K, F)."""
        return self.modes.modes[row].synthesis(self.frequency)

    def line(self, rows: NDArray[np.intp], frequency: float) -> Complex:
        """Several sweeps at one frequency, (R, K)."""
        return np.array([self.modes.modes[row].synthesis(np.array([frequency]))[:, 0] for row in rows])
