"""The digital twin with effects: one input, all outputs, and derivatives, for the gap workflow."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from analysis.experiment import Experiment
from analysis.gap.effect_card import EffectCard
from analysis.gap.model import Effects, Linearisation, SweepPoint, Tangent
from analysis.local_laws import LocalLaws
from analysis.material import MaterialBox
from simulation.effects.effect import Effect
from simulation.reduction.composition import STEP, Coefficients, Composite, composed
from simulation.reduction.effect_operators import BENDING_DEGREE, EffectOperators
from simulation.state.certified_range import require_certified
from simulation.state.damaged_spots import spots_slope, with_spots
from simulation.state.field_basis import field_basis
from simulation.state.plate_state import Circumstances, PlateState
from simulation.twin.instruments import Instruments
from simulation.twin.local_slopes import LocalSlopes
from simulation.twin.local_solution import REACH, LocalPlate, LocalSolution
from simulation.twin.reading import Reading
from simulation.twin.sensitivity import Sensitivity
from simulation.twin.strain_energy import SPECTRA, EnergySlopes, StateOf, StrainEnergy

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

REFERENCE = 25.0
"""Temperature of the plate whose largest strain energy is one, degrees Celsius."""


@dataclass(frozen=True)
class EffectTwin:
    """A plate with one input, K outputs, and a library of effects.

    Attributes
    ----------
    experiment : Experiment
    operators : EffectOperators
    library : mapping
        Effects by name, in the order in which they are applied.
    peak_energy : float
        Largest strain energy over 100 to 1500 Hz at 25 degrees Celsius and 1 V on the drive, J per V2: what
        `Circumstances.strain_energy` is counted in.
    reach : float
        Of `LocalSolution`; infinite where derivatives are wanted to rounding.
    """

    experiment: Experiment
    operators: EffectOperators
    library: Mapping[str, Effect]
    peak_energy: float | None = None
    reach: float = REACH

    @property
    def box(self) -> MaterialBox:
        """Materials within which the twin may be asked."""
        return self.operators.box

    @cached_property
    def cards(self) -> Mapping[str, EffectCard]:
        """The candidates this experiment can hold."""
        return {name: effect.card(self.experiment) for name, effect in self.library.items()}

    @cached_property
    def _instruments(self) -> Instruments:
        return Instruments.of(self.experiment)

    def _whole(self, state: PlateState, coefficients: Coefficients | None = None) -> Composite:
        """Compose a state, with the footprints of transducers as further ports, and their masses."""
        ops, footprints = self.operators, self.experiment.footprints
        whole = with_spots(ops, composed(ops, coefficients or self._coefficients(state)), state)
        if len(ops.footprints) != len(footprints):
            raise ValueError(
                f"{len(footprints)} footprints are declared, the operators hold {len(ops.footprints)}"
            )
        if not footprints:
            return whole
        rows, masses = ops.footprints, np.array([footprint.mass for footprint in footprints])
        return replace(
            whole, mass=whole.mass + (rows.T * masses) @ rows, coupling=np.hstack([whole.coupling, rows.T])
        )

    def referred(self, laws: LocalLaws) -> Self:
        """Return the twin with strain energies counted from those at 25 degrees Celsius of these laws."""
        low, high = max(100.0, self.operators.band[0]), min(1500.0, self.operators.band[1])
        point = SweepPoint(REFERENCE, 0.0, 1.0)

        def energies(lines: Real) -> Real:
            state = self._state(point, laws, {}, lines, np.ones(lines.size))
            return self._strain_energy(state, lambda _: state, lines, 1.0).at(np.zeros(lines.size))

        lines = np.linspace(low, high, 701)
        first = int(energies(lines).argmax())
        # a resonance of a sheet metal is narrower than the distance of these lines
        near = np.linspace(lines[max(first - 1, 0)], lines[min(first + 1, 700)], 401)
        return replace(self, peak_energy=float(energies(near).max()))

    def counted(self, laws: Sequence[LocalLaws], effects: Iterable[str]) -> Self:
        """Return the twin referred to the laws nearest to 25 degrees Celsius, where an effect needs energies."""
        if not any(self.library[name].needs_strain_energy for name in effects):
            return self
        return self.referred(min(laws, key=lambda law: abs(law.reference - REFERENCE)))

    def state(
        self, point: SweepPoint, laws: LocalLaws, effects: Mapping[str, Mapping[str, Any]], frequency: Real
    ) -> PlateState:
        """Return the plate with some effects on, fields at the points of `field_basis`.

        Values may be complex unless an effect among them follows the strain energy.
        """
        energy = self._settled(point, laws, effects, effects, frequency)
        return self._state(point, laws, effects, frequency, energy)

    def _settled(
        self,
        point: SweepPoint,
        laws: LocalLaws,
        effects: Mapping[str, Mapping[str, Any]],
        asked: Iterable[str],
        frequency: Real,
    ) -> Real:
        """Self-consistent strain energy as `Circumstances` want it; ones if no effect `asked` about wants it."""
        if not any(self.library[name].needs_strain_energy for name in asked):
            return np.ones(frequency.size)

        def state_of(energy: NDArray[Any]) -> PlateState:
            return self._state(point, laws, effects, frequency, energy)

        linear = state_of(np.zeros(frequency.size))
        require_certified(linear, self.operators)
        return self._strain_energy(linear, state_of, frequency, self._scale(point)).settled()

    def _scale(self, point: SweepPoint) -> float:
        """Relative strain energy per J/V2."""
        if self.peak_energy is None:
            raise ValueError("strain energies have no reference yet: call `referred` first")
        return point.level**2 / self.peak_energy

    def _state(
        self,
        point: SweepPoint,
        laws: LocalLaws,
        effects: Mapping[str, Mapping[str, Any]],
        frequency: Real,
        energy: NDArray[Any],
    ) -> PlateState:
        basis = field_basis(BENDING_DEGREE)
        seen = replace(Circumstances.of(self.experiment, point, frequency), strain_energy=energy)
        state = PlateState.baseline(basis.xi, basis.zeta, laws, point.temperature, frequency)
        for name, effect in self.library.items():
            if name in effects:
                state = effect.apply(state, seen, effects[name])
        return state

    def _strain_energy(self, linear: PlateState, state_of: StateOf, frequency: Real, scale: float) -> StrainEnergy:
        local = LocalPlate.of(self.operators, self._whole(linear), linear, self.reach)
        plate = self.experiment.plate
        density = plate.mass / plate.area
        return StrainEnergy.of(local, self._instruments.source, state_of, frequency, scale=scale, density=density)

    def _coefficients(self, state: PlateState) -> Coefficients:
        return Coefficients.of(state, self.operators.offset_range or 1.0)

    def _solved(
        self, state: PlateState, frequency: Real, coefficients: Coefficients | None = None
    ) -> LocalSolution:
        return LocalSolution.of(self.operators, self._whole(state, coefficients), state, frequency, self.reach)

    def frf(self, point: SweepPoint, laws: LocalLaws, effects: Effects, frequency: Real) -> Complex:
        """Return the outputs per unit of the input, (K, F)."""
        state = self.state(point, laws, effects, frequency)
        require_certified(state, self.operators)
        return self._reading(self._solved(state, frequency), state).response

    def _reading(self, solved: LocalSolution, state: PlateState) -> Reading:
        return Reading.of(solved, state, self._instruments, self.operators.capacitance)

    def linearise(
        self,
        point: SweepPoint,
        laws: LocalLaws,
        effects: Effects,
        frequency: Real,
        tangents: Sequence[Tangent] = (),
    ) -> Linearisation:
        """Transfer and its derivatives, see `analysis.gap.model.GapModel`."""
        ops = self.operators
        energy = self._settled(point, laws, effects, [*effects, *(name for name, _, _ in tangents)], frequency)

        def at(
            point: SweepPoint,
            laws: LocalLaws,
            effects: Mapping[str, Mapping[str, Any]],
            energy: NDArray[Any] = energy,
        ) -> PlateState:
            return self._state(point, laws, effects, frequency, energy)

        state = at(point, laws, effects)
        require_certified(state, ops)
        coefficients = self._coefficients(state)
        solved = self._solved(state, frequency, coefficients)
        slopes = LocalSlopes(ops, solved.basis, coefficients)
        reading = self._reading(solved, state)
        sensitivity = Sensitivity.of(solved, state, reading.drive, reading.sense)

        follower = at(point, laws, effects, energy + 1j * STEP)
        by_energy = None
        if any(np.imag(getattr(follower, name)).any() for name in (*SPECTRA, "log_gain", "phase")):
            by_energy = EnergySlopes.of(solved, self._instruments.source, state, follower, self._scale(point))

        def change(point: SweepPoint, laws: LocalLaws, effects: Mapping[str, Mapping[str, Any]]) -> Complex:
            stepped = at(point, laws, effects)
            moved = spots_slope(ops, slopes.by(stepped), stepped, solved.basis)
            if by_energy:
                stepped = at(point, laws, effects, energy + 1j * STEP * by_energy.by(moved, stepped))
            return reading.change(sensitivity.by(moved, stepped), stepped)

        def material(law: int) -> Complex:
            value = laws.value.astype(complex)
            value[law] += 1j * STEP
            return change(point, replace(laws, value=value), effects)

        def turned(law: int) -> Complex:
            return change(point, laws.tilted(1j * STEP * np.eye(3)[law], point.temperature), effects)

        def parameter(tangent: Tangent) -> Complex:
            name, parameter, absent = tangent
            values = dict(effects.get(name, absent))
            stepped = {**values, parameter: values[parameter] + 1j * STEP}
            return change(point, laws, {**effects, name: stepped})

        # a plate that is everywhere as warm as the oven asks nothing of the slopes
        follows = bool((state.temperature != point.temperature).any())
        by_slope = [turned(law) if follows else np.zeros_like(reading.response) for law in range(3)]
        warmer = replace(point, temperature=point.temperature + 1j * STEP)  # type: ignore[arg-type]
        return Linearisation(
            transfer=reading.response,
            by_material=np.array([material(law) for law in range(3)]),
            by_slope=np.array(by_slope),
            by_temperature=change(warmer, laws, effects),
            by_parameter=np.array([parameter(t) for t in tangents]).reshape(
                len(tangents), *reading.response.shape
            ),
        )
