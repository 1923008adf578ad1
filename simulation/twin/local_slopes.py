"""Derivatives of a plate's reduced matrices, in the coordinates of one local solution.

Each operator is transformed to these coordinates once, when the first parameter needs it; all derivatives are then
sums of small matrices.
"""

from dataclasses import fields
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from simulation.reduction.composition import (
    COMPLEX_STEP,
    Coefficients,
    Composite,
    OffsetPart,
    PatchMoves,
    coupling_of,
)
from simulation.reduction.effect_operators import EffectOperators
from simulation.state.plate_state import PlateState

FIELDS = (
    "temperature",
    "thickness",
    "modulus",
    "density",
    "modulus_x",
    "modulus_y",
    "in_plane_shear",
    "transverse_shear",
    "loss_x",
    "loss_y",
    "loss_cross",
    "loss_shear",
    "bond",
    "debonded",
    "patch_loss",
    "offset_x",
    "offset_y",
)
"""Attributes of a state on which `Coefficients` depend, besides its laws."""


class LocalSlopes:
    """Derivatives of the composite at `value` by any parameter of its coefficients.

    Parameters
    ----------
    ops : EffectOperators
    basis : (r, m) ndarray
        Local coordinates.
    value : Coefficients
    """

    def __init__(self, ops: EffectOperators, basis: Real, value: Coefficients) -> None:
        self._ops, self._basis, self._value = ops, basis, value
        self._stacks: dict[str, tuple[Real, NDArray[np.bool_]]] = {}
        self._last: tuple[PlateState, Coefficients] | None = None

    def by(self, stepped: PlateState) -> Composite:
        """Differentiate by the parameter whose imaginary step of `COMPLEX_STEP` gave `stepped`, without discs."""
        if not _changes_matrices(stepped):
            m = self._basis.shape[1]
            nothing = np.zeros((m, m))
            return Composite(nothing, nothing, nothing, nothing, np.zeros((m, self._ops.coupling.shape[-1])))
        d = self._rates(stepped)
        plate = self._energies(d.bending, d.membrane, d.shear)
        plate_loss = self._energies(d.bending_loss, d.membrane_loss, d.shear_loss)
        if d.patch_loss.any():
            plate_loss = plate_loss + self._summed("patch_membrane", d.patch_loss)
        mass = self._summed("mass", d.mass) + self._summed("rotary", d.rotary)
        if d.momentum:
            mass = mass + self._summed("momentum", d.momentum)
        for place, by in ((self._value.offset, d), (d.offset, self._value)):
            if place.any():
                part = OffsetPart.of(self._ops, by, place).on(self._zone)
                plate, plate_loss = plate + part.plate, plate_loss + part.plate_loss
                mass = mass + part.mass
        mass = mass + self._summed("patch_mass_alone", d.patch_mass)
        fixed, coupling = self._summed("patch_membrane", d.patch), self._coupling(d)
        for name in ("patch_alone", "patch_thicker"):
            fixed = fixed + self._summed(name, getattr(d, name))
        if d.moves.any():
            others = self._moves.by(d.moves)
            plate, plate_loss = plate + others.plate, plate_loss + others.plate_loss
            fixed, mass, coupling = fixed + others.fixed, mass + others.mass, coupling + others.coupling
        return Composite(plate, plate_loss, fixed, mass, coupling)

    def by_along_moves(self, stepped: PlateState) -> Composite:
        """Differentiate likewise what the moves of patches change: it follows moduli and d31, but no mass."""
        return self._moves.following(self._rates(stepped) if _changes_matrices(stepped) else None)

    def _rates(self, stepped: PlateState) -> Coefficients:
        if self._last is None or self._last[0] is not stepped:
            there = Coefficients.of(stepped, self._ops)
            rates = {entry.name: np.imag(getattr(there, entry.name)) / COMPLEX_STEP for entry in fields(there)}
            self._last = stepped, Coefficients(**rates)
        return self._last[1]

    def _coupling(self, d: Coefficients) -> Real:
        found = coupling_of(self._ops, d) * self._value.columns
        if d.columns.any():
            found = found + coupling_of(self._ops, self._value) * d.columns
        return np.asarray(self._basis.T @ found)

    @cached_property
    def _moves(self) -> PatchMoves:
        """What moves of patches change, in local coordinates."""
        return PatchMoves(self._ops, self._ops.patch_zone @ self._basis, self._value)

    @cached_property
    def _zone(self) -> Real:
        """Motions around the sensor of the local coordinates, (q, m)."""
        return np.asarray(self._ops.zone @ self._basis)

    def _energies(self, bending: Real, membrane: Real, shear: Real) -> Real:
        return self._summed("bending", bending) + self._summed("membrane", membrane) + self._summed("shear", shear)

    def _carried(self, matrix: Real) -> Real:
        return np.asarray(self._basis.T @ matrix @ self._basis)

    def _summed(self, name: str, coefficients: Real) -> Real:
        """Sum of coefficients times the operators `name`, (m, m)."""
        flat = np.ravel(coefficients)
        whole = getattr(self._ops, name)
        whole = whole.reshape(-1, *whole.shape[-2:])
        m = self._basis.shape[1]
        if not flat.any():
            return np.zeros((m, m))
        if name not in self._stacks:
            self._stacks[name] = np.zeros((len(whole), m, m)), np.zeros(len(whole), dtype=bool)
        small, carried = self._stacks[name]
        for k in np.flatnonzero((flat != 0.0) & ~carried):
            small[k] = self._carried(whole[k])
            carried[k] = True
        return np.asarray((flat @ small.reshape(len(small), -1)).reshape(m, m))


def _changes_matrices(stepped: PlateState) -> bool:
    """Whether a value that `Coefficients` depend on has a complex step."""
    laws = (stepped.laws.value, stepped.laws.slope, stepped.laws.curvature)
    of_fields = any(np.iscomplexobj(one) for one in (*laws, *(getattr(stepped, name) for name in FIELDS)))
    return of_fields or stepped.departures.stepped_plate
