"""Transducers on a reduced plate: where they act, what they weigh, and what their departures change."""

from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from analysis.arrays import Real
from simulation.reduction.composition import COMPLEX_STEP, Composite
from simulation.state.departures import Departures
from simulation.state.plate_state import PlateState
from simulation.twin.reduced_plate import CompositeSlopes


@dataclass(frozen=True)
class Transducers:
    """Footprints of transducers in some coordinates.

    Attributes
    ----------
    rows : (S, r) ndarray
        Mean deflection over each, where it is.
    slopes : (3, S, r) ndarray
        Derivatives of the rows by shifts along x and y, 1/m, and by the share by which the areas are larger.
    masses : (S,) ndarray, kg
    """

    rows: Real
    slopes: Real
    masses: Real

    @classmethod
    def of(cls, rows: Real, slopes: Real, masses: Real, away: Departures) -> Self:
        """Move, widen and load footprints as their departures say; to first order of the shift, of some 0.3 mm.

        Parameters
        ----------
        rows : (S, r) ndarray
            As declared.
        slopes : (3, S, r) ndarray
        masses : (S,) ndarray, kg
            As declared.

        Returns
        -------
        Transducers
        """
        shift = np.array([np.broadcast_to(np.real(one), len(rows)) for one in _changes(away)])
        moved = rows + np.einsum("as,asr->sr", shift, slopes) if shift.any() else rows
        return cls(moved, slopes, masses + np.real(away.added_mass))

    @property
    def inertia(self) -> Real:
        """What the masses add to the mass matrix, (r, r)."""
        return np.asarray((self.rows.T * self.masses) @ self.rows)

    def on(self, basis: Real) -> Self:
        """Return the same in the coordinates that are the columns of `basis` (r, m)."""
        return replace(self, rows=self.rows @ basis, slopes=self.slopes @ basis)


@dataclass(frozen=True)
class TransducerSlopes:
    """Derivatives of a plate's matrices, and of its transducers' rows, which are the ports after the patches."""

    plate: CompositeSlopes
    transducers: Transducers

    def by(self, stepped: PlateState) -> Composite:
        """Differentiate by the parameter whose imaginary step of `COMPLEX_STEP` gave `stepped`."""
        local, away, here = self.plate.by(stepped), stepped.departures, self.transducers
        count = len(here.rows)
        steps = (*_changes(away), away.added_mass)
        *moved, heavier = (np.broadcast_to(np.imag(one) / COMPLEX_STEP, count) for one in steps)
        if not (np.any(moved) or heavier.any()):
            return local
        rows = np.einsum("as,asr->sr", moved, here.slopes)
        half = (rows.T * here.masses) @ here.rows
        mass = local.mass + half + half.T + (here.rows.T * heavier) @ here.rows
        return replace(local, mass=mass, coupling=np.hstack([local.coupling, rows.T]))

    def by_along_moves(self, stepped: PlateState) -> Composite:
        """Differentiate likewise what the moves of patches change."""
        return self.plate.by_along_moves(stepped)


def _changes(away: Departures) -> tuple[Any, Any, Any]:
    """Return what changes the rows, in the order of `Transducers.slopes`."""
    return away.place_x, away.place_y, away.contact
