"""A reduced plate as declared, of any material: the twin of model updating."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from analysis.arrays import Real
from analysis.material import MaterialBox
from simulation.reduction.composition import COMPLEX_STEP, Composite
from simulation.reduction.reduced_model import ReducedModel
from simulation.shell.rigidity import plane_stress_moduli
from simulation.state.plate_state import AS_DECLARED, PlateState

UNIFORM = (
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
)
ABSENT = ("area_mass", "area_resistance", "area_stiffness", "offset_x", "offset_y", "patch_loss", "debonded")
"""Attributes of a state that are 1, and those that are 0, if the plate is as declared."""


@dataclass(frozen=True)
class DeclaredPlate:
    """A `simulation.twin.local_plate.ReducedPlate` of uniform material, without effects on the plate itself.

    Sufficient for laws at any temperature and for effects on the signals.
    """

    reduced: ReducedModel

    @property
    def box(self) -> MaterialBox:
        """Of `reduced`."""
        return self.reduced.box

    @property
    def band(self) -> tuple[float, float]:
        """Of `reduced`."""
        return self.reduced.band

    @property
    def error(self) -> float:
        """Of `reduced`."""
        return self.reduced.error

    @property
    def capacitance(self) -> Real:
        """Of `reduced`."""
        return self.reduced.capacitance

    @property
    def footprints(self) -> Real:
        """Of `reduced`."""
        return self.reduced.footprints

    @cached_property
    def footprint_slopes(self) -> Real:
        """Zeros: footprints are as declared."""
        return np.zeros((3, *self.reduced.footprints.shape))

    @cached_property
    def deflection_slopes(self) -> Real:
        """Empty, as `points`."""
        return np.zeros((2, 0, self.reduced.size))

    @cached_property
    def damping(self) -> Real:
        """Damping matrix of the supports' dashpots, (r, r), N s/m."""
        return np.asarray(self.reduced.dashpots @ self.reduced.dashpots.T)

    @cached_property
    def normal(self) -> Real:
        """Zeros: distributed loads are not supported."""
        return np.zeros((self.reduced.size,) * 2)

    @cached_property
    def points(self) -> Real:
        """Empty: point loads are not supported."""
        return np.zeros((0, 2))

    @cached_property
    def deflection(self) -> Real:
        """Empty, as `points`."""
        return np.zeros((0, self.reduced.size))

    @cached_property
    def places(self) -> Real:
        """Empty: nothing can be attached anywhere."""
        return np.zeros((0, 2))

    @cached_property
    def place_deflection(self) -> Real:
        """Empty, as `places`."""
        return np.zeros((0, self.reduced.size))

    @cached_property
    def place_compliance(self) -> Real:
        """Empty, as `places`."""
        return np.zeros(0)

    @property
    def place_spacing(self) -> float:
        """Any length, without a place."""
        return 1.0

    def require(self, state: PlateState) -> None:
        """ValueError for a state that is not the plate as declared, or outside the box."""
        off = [name for name in UNIFORM if np.any(np.real(getattr(state, name)) != 1.0)]
        off += [name for name in ABSENT if np.any(np.real(getattr(state, name)) != 0.0)]
        off += [name for name in ("point_loads", "attached", "discs") if getattr(state, name)]
        if (state.temperature != state.temperature[0]).any():
            off.append("temperature over the plate")
        if state.departures is not AS_DECLARED:
            off.append("departures")
        if off:
            raise ValueError(
                f"{', '.join(off)}: this twin holds the plate as declared only; effects on the plate need the "
                "operators of simulation.twin.effect_plate.EffectPlate"
            )
        self.reduced.require(*(float(np.real(value)) for value in _constants(state)))

    def composed(self, state: PlateState) -> Composite:
        """Return the matrices at the material of a state."""
        e, nu, eta = _constants(state)
        c1, c2 = plane_stress_moduli(e, nu)
        plate = c1 * self.reduced.stiffness_1 + c2 * self.reduced.stiffness_2
        return Composite(
            plate, eta * plate, self.reduced.stiffness_patch, np.eye(self.reduced.size), self.reduced.coupling
        )

    def slopes(self, state: PlateState, basis: Real) -> "MaterialSlopes":
        """Return derivatives by the material, which do not depend on the state."""
        first, second = (
            basis.T @ matrix @ basis for matrix in (self.reduced.stiffness_1, self.reduced.stiffness_2)
        )
        return MaterialSlopes(first, second, self.reduced.coupling.shape[1])


@dataclass(frozen=True)
class MaterialSlopes:
    """Derivatives of the plate's matrices by its material, in m local coordinates.

    Attributes
    ----------
    stiffness_1, stiffness_2 : (m, m) ndarray
        As in `ReducedModel`.
    patches : int
    """

    stiffness_1: Real
    stiffness_2: Real
    patches: int

    def by(self, stepped: PlateState) -> Composite:
        """Differentiate by the parameter whose imaginary step of `COMPLEX_STEP` gave `stepped`."""
        e, nu, eta = _constants(stepped)
        c1, c2 = plane_stress_moduli(e, nu)
        nothing = np.zeros_like(self.stiffness_1)
        return Composite(
            self._combined(c1, c2),
            self._combined(eta * c1, eta * c2),
            nothing,
            nothing,
            np.zeros((len(nothing), self.patches)),
        )

    def by_along_moves(self, stepped: PlateState) -> Composite:
        """Return nothing: patches of such a plate are where they were declared."""
        nothing = np.zeros_like(self.stiffness_1)
        return Composite(nothing, nothing, nothing, nothing, np.zeros((len(nothing), self.patches)))

    def _combined(self, c1: Any, c2: Any) -> Real:
        return np.asarray(
            np.imag(c1) / COMPLEX_STEP * self.stiffness_1 + np.imag(c2) / COMPLEX_STEP * self.stiffness_2
        )


def _constants(state: PlateState) -> tuple[Any, Any, Any]:
    """E [Pa], nu and eta of a plate at uniform temperature; complex for a stepped state."""
    laws, temperature = state.laws, state.temperature[0]
    return laws.youngs_modulus(temperature), laws.poisson_ratio(temperature), laws.loss_factor(temperature)
