"""Fields known at points of a lattice that lie on a plate, shown up to the plate's own edges."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real
from analysis.plate import Plate
from app.view.chart import Map

CELLS_IN_ONE = 6
"""Cells of a picture in one of the lattice."""


def edges_of(plate: Plate) -> list[Real]:
    """Corners (C, 2), m, of a plate's outline and holes."""
    return [loop.polygon for loop in (plate.loop, *plate.hole_loops)]


def widened(at: Real, by: int) -> Real:
    """Return places (N,) with `by` more on either side, as far apart as the outermost ones."""
    beyond = np.arange(1, by + 1)
    before = at[0] - beyond[::-1] * (at[1] - at[0])
    return np.concatenate([before, at, at[-1] + beyond * (at[-1] - at[-2])])


def filled(field: Complex) -> Complex:
    """Continue a field (X, Y) past the plate's edge, where it is NaN: straight on, by the values next to it."""
    found = field.copy()
    while np.isnan(found).any() and not np.isnan(found).all():
        wide = np.pad(found, 2, constant_values=np.nan)
        guesses = []
        for axis in (0, 1):
            for step in (1, -1):
                next_to, behind = (np.roll(wide, k * step, axis)[2:-2, 2:-2] for k in (1, 2))
                guesses.append(np.where(np.isnan(behind), next_to, 2.0 * next_to - behind))
        beside = np.stack(guesses)
        known = ~np.isnan(beside)
        reached = np.isnan(found) & known.any(axis=0)
        mean = np.where(known, beside, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
        size = np.nanmax(np.abs(field))  # far from the plate straight on would lead anywhere
        found[reached] = (mean * np.minimum(1.0, 1.5 * size / np.maximum(np.abs(mean), 1e-300)))[reached]
    return found


@dataclass(frozen=True)
class FromAbove:
    """A lattice made finer where the plate's edges cut it.

    Attributes
    ----------
    x, y : (X,), (Y,) ndarray
        Of the lattice, m.
    plate : Plate
    """

    x: Real
    y: Real
    plate: Plate

    @cached_property
    def _fine(self) -> tuple[Real, Real, NDArray[np.bool_]]:
        """Finer places along both axes, and which of their points (x, y) lie off the plate."""
        wide = [widened(at, 2) for at in (self.x, self.y)]
        x, y = (np.linspace(float(at[0]), float(at[-1]), CELLS_IN_ONE * (len(at) - 1) + 1) for at in wide)
        points = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
        return x, y, ~self.plate.contains(points).reshape(len(x), len(y))

    def amplitude(self, field: Complex) -> Map:
        """Return amplitudes of a field (X, Y) as a map; NaN off the plate."""
        from scipy.ndimage import map_coordinates

        if not np.isnan(field).any():
            return Map(self.x, self.y, np.abs(field).T)
        x, y, off = self._fine
        whole = filled(np.pad(field, 2, constant_values=np.nan))
        rows = [np.arange(CELLS_IN_ONE * (size - 1) + 1) / CELLS_IN_ONE for size in whole.shape]
        places = np.meshgrid(*rows, indexing="ij")
        real, imaginary = (map_coordinates(part, places, order=1) for part in (whole.real, whole.imag))
        return Map(x, y, np.where(off, np.nan, np.hypot(real, imaginary)).T)
