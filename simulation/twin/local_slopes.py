"""Derivatives of a plate's reduced matrices, in the coordinates of one local solution.

Each operator is transformed to these coordinates once, when the first parameter needs it; all derivatives are then
sums of small matrices.
"""

from dataclasses import fields, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from simulation.reduction.composition import STEP, Coefficients, Composite, OffsetPart, PatchChanges, coupling_of
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

EACH_PATCH = ("patch_each", "patch_thicker", "patch_mass")
"""Coefficients of patches that are not as declared, besides their moves."""


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

    def by(self, stepped: PlateState) -> Composite:
        """Differentiate by the parameter whose imaginary step of `STEP` gave `stepped`, without discs."""
        m = self._basis.shape[1]
        laws = (stepped.laws.value, stepped.laws.slope, stepped.laws.curvature)
        of_fields = any(np.iscomplexobj(one) for one in (*laws, *(getattr(stepped, name) for name in FIELDS)))
        if not (of_fields or stepped.departures.stepped_plate):
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
        fixed, coupling = self._summed("patch_membrane", d.patch), self._coupling(d)
        if d.debonded.any():
            fixed = fixed - self._summed("patch_alone", d.debonded)
        if any(one.any() for one in (d.patch_each, d.patch_thicker, d.moves)):
            others = self._patches.summed(self._value, d)
            plate, plate_loss = plate + others.plate, plate_loss + others.plate_loss
            fixed, mass, coupling = fixed + others.fixed, mass + others.mass, coupling + others.coupling
        return Composite(plate, plate_loss, fixed, mass, coupling)

    def by_along_moves(self, stepped: PlateState) -> Composite:
        """Differentiate likewise what the moves of patches change: it follows the plate's moduli and d31."""
        nothing = replace(self._value, **{name: np.zeros_like(getattr(self._value, name)) for name in EACH_PATCH})
        found = self._patches.summed(self._rates(stepped), nothing)
        return replace(found, fixed=np.zeros_like(found.fixed), mass=np.zeros_like(found.mass))

    def _rates(self, stepped: PlateState) -> Coefficients:
        there = Coefficients.of(stepped, self._ops)
        return Coefficients(**{entry.name: np.imag(getattr(there, entry.name)) / STEP for entry in fields(there)})

    def _coupling(self, d: Coefficients) -> Real:
        found = coupling_of(self._ops, d) * self._value.columns
        if d.columns.any():
            found = found + coupling_of(self._ops, self._value) * d.columns
        return np.asarray(self._basis.T @ found)

    @cached_property
    def _patches(self) -> PatchChanges:
        """What patches that are not as declared change, in local coordinates."""
        return PatchChanges(self._ops, self._ops.patch_zone @ self._basis)

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
