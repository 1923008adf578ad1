"""A reduced plate in any state caused by effects: the twin of the gap workflow.

Its matrices' derivatives are taken in the coordinates of one local solution. Each operator is transformed to these
coordinates once, when the first parameter needs it; all derivatives are then sums of small matrices.
"""

from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.material import MaterialBox
from simulation.reduction.composition import (
    COMPLEX_STEP,
    Coefficients,
    Composite,
    OffsetPart,
    PatchMoves,
    composed,
    coupling_of,
)
from simulation.reduction.effect_operators import EffectOperators
from simulation.state.damaged_spots import spots_slope, with_spots
from simulation.state.plate_state import FARTHEST_MODULI, FARTHEST_SHEAR, PlateState

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


KEPT = 64
"""Derivatives that are kept, the first ones: laws, and what a fit has free, are asked for again where patches have
moved. A screening asks for hundreds, of which each would take a third of a megabyte."""


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
        self._known: dict[int, tuple[PlateState, Composite]] = {}

    def by(self, stepped: PlateState) -> Composite:
        """Differentiate by the parameter whose imaginary step of `COMPLEX_STEP` gave `stepped`, without discs."""
        known = self._known.get(id(stepped))
        if known is None:
            known = stepped, self._by(stepped)
            if len(self._known) < KEPT:
                self._known[id(stepped)] = known  # keeps the state, so that no other takes its identity
        return known[1]

    def _by(self, stepped: PlateState) -> Composite:
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


ANISOTROPY = (0.88, 1.12)
THICKNESS = (0.9, 1.1)
BOND = (0.55, 1.0)
TRANSVERSE = (0.6, 1.4)
"""Over the nominal values: `extreme_states`, of the thickness all together, reach the ends of these ranges."""
SPREAD = 1.3
"""Largest ratio of a local modulus to the one at the mean temperature."""


def require_certified(state: PlateState, ops: EffectOperators) -> None:
    """ValueError, naming value and range, for a state for which the operators' error was not measured."""
    temperature = np.real(state.mean_temperature)
    laws = state.laws
    asked: list[tuple[str, Any, tuple[float, float]]] = [
        ("youngs_modulus [Pa]", laws.youngs_modulus(temperature), ops.box.youngs_modulus),
        ("poisson_ratio", laws.poisson_ratio(temperature), ops.box.poisson_ratio),
        ("loss_factor", laws.loss_factor(temperature), ops.box.loss_factor),
        ("modulus along x over E", state.modulus_x, ANISOTROPY),
        ("modulus along y over E", state.modulus_y, ANISOTROPY),
        ("in-plane shear modulus over its isotropic value", state.in_plane_shear, ANISOTROPY),
        ("local thickness over the nominal", state.thickness, THICKNESS),
        ("transverse shear modulus over its isotropic value", state.transverse_shear, TRANSVERSE),
        ("local density over the nominal", state.density, THICKNESS),
        ("bond factor", state.bond, BOND),
        ("bonded share of a patch", 1.0 - np.asarray(state.debonded), BOND),
        ("offset along x [m]", state.offset_x, (-ops.offset_range, ops.offset_range)),
        ("offset along y [m]", state.offset_y, (-ops.offset_range, ops.offset_range)),
        (
            "local modulus over its mean",
            state.modulus * laws.youngs_modulus(state.temperature) / laws.youngs_modulus(temperature),
            (1.0 / SPREAD, SPREAD),
        ),
    ]
    if len(ops.shear) > 1:
        asked += _of_the_sheet(state)
    for name, value, (low, high) in asked:
        values = np.atleast_1d(np.real(value))
        slack = 1e-9 * max(abs(low), abs(high))
        outside = values[~((values >= low - slack) & (values <= high + slack))]
        if outside.size:
            raise ValueError(
                f"{name} {outside[0]:.6g} is outside the twin's certified range, {low:.6g} to {high:.6g}"
            )


def _of_the_sheet(state: PlateState) -> list[tuple[str, Any, tuple[float, float]]]:
    """Return ratios of an orthotropic sheet over the declared ones, with their ranges."""
    away = state.departures
    moduli = (np.exp(-FARTHEST_MODULI), np.exp(FARTHEST_MODULI))
    across = tuple(np.exp(sign * (FARTHEST_SHEAR + FARTHEST_MODULI)) for sign in (-1.0, 1.0))
    return [
        ("Ey/Ex over the declared ratio", away.modulus_y / away.modulus_x, moduli),
        ("shear modulus of the sheet over its declared share", away.in_plane_shear, moduli),
        ("transverse shear modulus xz over its declared share", away.shear_x, across),
        ("transverse shear modulus yz over its declared share", away.shear_y, across),
    ]


@dataclass(frozen=True)
class EffectPlate:
    """A `simulation.twin.local_plate.ReducedPlate` with matrices composed of `operators`."""

    operators: EffectOperators

    @property
    def box(self) -> MaterialBox:
        """Of `operators`."""
        return self.operators.box

    @property
    def band(self) -> tuple[float, float]:
        """Of `operators`."""
        return self.operators.band

    @property
    def error(self) -> float:
        """Of `operators`."""
        return self.operators.error

    @property
    def capacitance(self) -> Real:
        """Of `operators`."""
        return self.operators.capacitance

    @property
    def footprints(self) -> Real:
        """Of `operators`."""
        return self.operators.footprints

    @property
    def footprint_slopes(self) -> Real:
        """Of `operators`."""
        return self.operators.footprint_slopes

    @property
    def deflection_slopes(self) -> Real:
        """Of `operators`."""
        return self.operators.deflection_slopes

    @property
    def damping(self) -> Real:
        """Of `operators`."""
        return self.operators.damping

    @property
    def normal(self) -> Real:
        """Of `operators`."""
        return self.operators.normal

    @property
    def points(self) -> Real:
        """Of `operators`."""
        return self.operators.points

    @property
    def deflection(self) -> Real:
        """Of `operators`."""
        return self.operators.deflection

    @property
    def places(self) -> Real:
        """Of `operators`."""
        return self.operators.places

    @property
    def place_deflection(self) -> Real:
        """Of `operators`."""
        return self.operators.place_deflection

    @property
    def place_compliance(self) -> Real:
        """Of `operators`."""
        return self.operators.place_compliance

    @property
    def place_spacing(self) -> float:
        """Of `operators`."""
        return self.operators.place_spacing

    def require(self, state: PlateState) -> None:
        """ValueError, naming value and range, for a state outside the range for which the error was measured."""
        require_certified(state, self.operators)

    def composed(self, state: PlateState) -> Composite:
        """Return the matrices of a state, its damaged spots included."""
        return with_spots(self.operators, composed(self.operators, self._coefficients(state)), state)

    def slopes(self, state: PlateState, basis: Real) -> "EffectSlopes":
        """Return derivatives of `composed`."""
        return EffectSlopes(self.operators, LocalSlopes(self.operators, basis, self._coefficients(state)), basis)

    def _coefficients(self, state: PlateState) -> Coefficients:
        return Coefficients.of(state, self.operators)


@dataclass(frozen=True)
class EffectSlopes:
    """Derivatives of a plate's matrices by its fields and by its damaged spots, in local coordinates."""

    operators: EffectOperators
    fields: LocalSlopes
    basis: Real

    def by(self, stepped: PlateState) -> Composite:
        """Differentiate by the parameter whose imaginary step of `COMPLEX_STEP` gave `stepped`."""
        return spots_slope(self.operators, self.fields.by(stepped), stepped, self.basis)

    def by_along_moves(self, stepped: PlateState) -> Composite:
        """Differentiate likewise what the moves of patches change."""
        return self.fields.by_along_moves(stepped)
