"""Derivatives of a transfer that is linear in the moves of patches, moves included.

With H = H0 + D m for moves m, a derivative of H is that of H0 plus that of D times m. The latter is the slope,
along the moves, of the derivatives of a plate whose matrices follow them: a difference of two plates a small share
of the moves apart. Without it a fit that moves patches by tenths of a millimetre has derivatives that are wrong by
some per cent, takes three times the steps, and ends beside its minimum.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from analysis.arrays import Real
from simulation.reduction.composition import Composite
from simulation.state.plate_state import PlateState
from simulation.twin.local_plate import LocalPlate
from simulation.twin.local_solution import LocalSolution
from simulation.twin.reduced_plate import CompositeSlopes

MOVE_SHARE = 1e-4
"""Share of the moves for the difference: it has an error of some parts of this share, and rounding of 1e-12 over
it. With 1e-2 derivatives were wrong by 0.4 %, and fits ended beside their minimum."""


@dataclass(frozen=True)
class MovedPatches:
    """A plate whose patches have made a share of their moves, in coordinates that are orthonormal in its mass.

    Attributes
    ----------
    solved : LocalSolution
    plain : CompositeSlopes
        Before the moves, in the coordinates there.
    turn : (m, m) ndarray
        From these coordinates to those of `solved`.
    """

    solved: LocalSolution
    plain: CompositeSlopes
    turn: Real

    @classmethod
    def of(cls, solved: LocalSolution, plain: CompositeSlopes, along: Composite) -> Self:
        """Move the patches of a solved plate.

        Parameters
        ----------
        solved : LocalSolution
        plain : CompositeSlopes
        along : Composite
            Derivative of its matrices along the moves.
        """
        here, local = solved.plate, solved.composite
        turn = np.eye(len(local.mass)) - 0.5 * MOVE_SHARE * along.mass
        moved = _turned(_sum(local, along), turn)
        plate = LocalPlate(
            here.basis @ turn, replace(moved, mass=local.mass), turn @ here.normal @ turn, here.operators
        )
        return cls(solved.likewise(plate), plain, turn)

    def by(self, stepped: PlateState) -> Composite:
        """Differentiate by the parameter whose imaginary step of `COMPLEX_STEP` gave `stepped`."""
        return _turned(_sum(self.plain.by(stepped), self.plain.by_along_moves(stepped)), self.turn)

    def by_along_moves(self, stepped: PlateState) -> Composite:
        """Differentiate likewise what the moves change."""
        return _turned(self.plain.by_along_moves(stepped), self.turn)


def _sum(local: Composite, along: Composite) -> Composite:
    """Add the share of a derivative along the moves; ports after the patches do not move."""
    coupling = local.coupling.copy()
    coupling[:, : along.coupling.shape[1]] += MOVE_SHARE * along.coupling
    return Composite(
        plate=local.plate + MOVE_SHARE * along.plate,
        plate_loss=local.plate_loss + MOVE_SHARE * along.plate_loss,
        fixed=local.fixed + MOVE_SHARE * along.fixed,
        mass=local.mass + MOVE_SHARE * along.mass,
        coupling=coupling,
    )


def _turned(local: Composite, turn: Real) -> Composite:
    plate, plate_loss, fixed, mass = (
        turn @ one @ turn if one.any() else one for one in (local.plate, local.plate_loss, local.fixed, local.mass)
    )
    return Composite(plate, plate_loss, fixed, mass, turn @ local.coupling)
