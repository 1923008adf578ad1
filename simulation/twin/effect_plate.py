"""A reduced plate in any state caused by effects: the twin of the gap workflow."""

from dataclasses import dataclass

from analysis.arrays import Real
from analysis.material import MaterialBox
from simulation.reduction.composition import Coefficients, Composite, composed
from simulation.reduction.effect_operators import EffectOperators
from simulation.state.certified_range import require_certified
from simulation.state.damaged_spots import spots_slope, with_spots
from simulation.state.plate_state import PlateState
from simulation.twin.local_slopes import LocalSlopes


@dataclass(frozen=True)
class EffectPlate:
    """A `simulation.twin.reduced_plate.ReducedPlate` with matrices composed of `operators`."""

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
