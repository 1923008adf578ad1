"""A reduced plate with an experiment's instruments, in any state caused by effects."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Generic, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.effect_card import EffectCard
from analysis.experiment import Experiment
from analysis.material import LocalLaws, MaterialBox
from analysis.recordings.sweep_point import SweepPoint
from analysis.twin_model import NO_EFFECTS
from simulation.effects.effect import Effect
from simulation.effects.library import apply_all
from simulation.reduction.composition import COMPLEX_STEP, Composite
from simulation.reduction.effect_operators import BENDING_DEGREE
from simulation.state.field_basis import field_basis
from simulation.state.plate_state import Circumstances, Departures, PlateState
from simulation.tolerances import Tolerance, depart
from simulation.twin.instruments import Instruments
from simulation.twin.local_plate import KEPT_MODES_FACTOR, CompositeSlopes, LocalPlate, ReducedPlate
from simulation.twin.local_solution import LocalSolution
from simulation.twin.strain_energy import StateOf, StrainEnergy

StateEffects = Mapping[str, Mapping[str, Any]]
"""As `analysis.twin_model.Effects`; values may be complex."""


@dataclass(frozen=True)
class States:
    """States of one plate.

    Attributes
    ----------
    experiment : Experiment or None
        Gives the circumstances for effects; None for a plate without effects.
    library : mapping
        Effects by name, in the order in which they are applied.
    tolerances : mapping
        Declared quantities that are not exact, by name, applied before the effects; no candidates.
    """

    experiment: Experiment | None = None
    library: Mapping[str, Effect] = field(default_factory=dict)
    tolerances: Mapping[str, Effect] = field(default_factory=dict)

    @cached_property
    def cards(self) -> Mapping[str, EffectCard]:
        """Cards of the effects that are possible in this experiment."""
        if self.experiment is None:
            return {}
        return {name: effect.card(self.experiment) for name, effect in self.library.items()}

    @cached_property
    def tolerance_cards(self) -> Mapping[str, EffectCard]:
        """Cards of the declared quantities that are not exact."""
        if self.experiment is None:
            return {}
        return {name: one.card(self.experiment) for name, one in self.tolerances.items()}

    @cached_property
    def _circumstances(self) -> Circumstances:
        """Declared ones, taken once: a scan has hundreds of points, and every derivative asks."""
        if self.experiment is None:
            raise ValueError("this plate has no experiment that gives effects their circumstances")
        return Circumstances.of(self.experiment, SweepPoint(20.0, 0.0, 1.0), np.zeros(1))

    @cached_property
    def _made_elsewhere(self) -> bool:
        """Whether the twin was made about other values than those declared."""
        return any(isinstance(one, Tolerance) and one.made_at for one in self.tolerances.values())

    def follow_energy(self, effects: Iterable[str]) -> bool:
        """Whether any of some effects depends on the strain energy."""
        return any(name in self.library and self.library[name].needs_strain_energy for name in effects)

    def at(
        self, point: SweepPoint, laws: LocalLaws, effects: StateEffects, frequency: Real, energy: NDArray[Any]
    ) -> PlateState:
        """Return the plate with some effects on, fields at the points of `field_basis`.

        Parameters
        ----------
        effects : mapping
            Values of those that are on.
        frequency : (F,) ndarray
            Hz.
        energy : (F,) ndarray
            Relative strain energy, see `Circumstances`.

        Raises
        ------
        ValueError
            For an effect that is not in the library.
        """
        basis = field_basis(BENDING_DEGREE)
        if self.experiment is not None:
            laws = self.experiment.plate.grown(laws)
        state = PlateState.baseline(basis.xi, basis.zeta, laws, point.temperature, frequency)
        if not effects and not self._made_elsewhere:
            return state
        seen = replace(self._circumstances, frequency=frequency, point=point, strain_energy=energy)
        departed = depart(self.tolerances, state, seen, effects) if self.tolerances else state
        others = {name: values for name, values in effects.items() if name not in self.tolerances}
        return apply_all(self.library, departed, seen, others)


Plate = TypeVar("Plate", bound=ReducedPlate, covariant=True)
REFERENCE_TEMPERATURE = 25.0
"""Reference temperature of the relative strain energy, degrees Celsius."""


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


@dataclass(frozen=True)
class InstrumentedPlate(Generic[Plate]):
    """A plate with its inputs and outputs.

    Attributes
    ----------
    plate : ReducedPlate
        As declared, or in any state caused by effects.
    instruments : Instruments
        Its ports are the patches, then the footprints of `plate`. Its input is the first.
    experiment : Experiment or None
        Gives the masses of transducers, and the circumstances for effects.
    library : mapping
        Effects by name, in the order in which they are applied; none for the plate as declared.
    tolerances : mapping
        Declared quantities that are not exact, by name; none for the plate exactly as declared.
    peak_energy : float or None
        Largest strain energy over 100 to 1500 Hz at 25 degrees Celsius and 1 V on the first input, J per V2: the
        unit of `Circumstances.strain_energy`.
    reach : float
        See `LocalSolution`; infinite for derivatives exact to rounding.
    further : tuple of Instruments
        Instruments with each of the other inputs driven.
    """

    plate: Plate
    instruments: Instruments
    experiment: Experiment | None = None
    library: Mapping[str, Effect] = field(default_factory=dict)
    tolerances: Mapping[str, Effect] = field(default_factory=dict)
    peak_energy: float | None = None
    reach: float = KEPT_MODES_FACTOR
    further: tuple[Instruments, ...] = ()

    def __post_init__(self) -> None:
        declared = len(self.experiment.footprints) if self.experiment else len(self.plate.footprints)
        if len(self.plate.footprints) != declared:
            raise ValueError(
                f"twin: {declared} footprints are declared, the reduced plate holds {len(self.plate.footprints)}"
            )
        count = self.plate.capacitance.size + len(self.plate.footprints)
        for port in (port for one in (self.instruments, *self.further) for port in (*one.driving, *one.seen)):
            if not 0 <= port < count:
                raise ValueError(f"twin: port {port} is outside 0 to {count - 1}")

    @classmethod
    def of(
        cls,
        experiment: Experiment,
        plate: Plate,  # type: ignore[misc]
        library: Mapping[str, Effect] | None = None,
        tolerances: Mapping[str, Effect] | None = None,
    ) -> Self:
        """Join an experiment's instruments to its reduced plate.

        Parameters
        ----------
        plate : ReducedPlate
        library : mapping of str to Effect, optional
            In the order in which they are applied; none for the plate as declared.
        tolerances : mapping of str to Effect, optional
            Declared quantities that are not exact.

        Returns
        -------
        Twin
        """
        first, *others = (Instruments.of(experiment, source) for source in experiment.inputs)
        return cls(plate, first, experiment, library or {}, tolerances or {}, further=tuple(others))

    @property
    def box(self) -> MaterialBox:
        """Certified materials of the twin, at any temperature."""
        return self.plate.box if self.experiment is None else self.experiment.plate.ungrown(self.plate.box)

    @property
    def band(self) -> tuple[float, float]:
        """Certified band of the twin, Hz."""
        return self.plate.band

    @property
    def error(self) -> float:
        """Certified error of the reduced plate."""
        return self.plate.error

    @property
    def outputs(self) -> int:
        """Number of outputs K."""
        return len(self.instruments.pickups)

    @property
    def cards(self) -> Mapping[str, EffectCard]:
        """Cards of the effects that are possible in this experiment."""
        return self.states.cards

    @property
    def tolerance_cards(self) -> Mapping[str, EffectCard]:
        """Cards of the declared quantities that are not exact: free in every fit, and no candidates."""
        return self.states.tolerance_cards

    def driven_at(self, point: SweepPoint) -> Instruments:
        """Return the instruments with the input of a sweep driven."""
        return (self.instruments, *self.further)[point.source]

    @cached_property
    def states(self) -> States:
        """States of the plate with effects."""
        return States(self.experiment, self.library, self.tolerances)

    def state(
        self, laws: LocalLaws, frequency: Real, effects: StateEffects = NO_EFFECTS, point: SweepPoint | None = None
    ) -> PlateState:
        """Return the plate with some effects on, fields at the points of `field_basis`.

        Parameters
        ----------
        frequency : (F,) ndarray, Hz
        effects : mapping
            Values of those that are on; complex ones only if none of the effects depends on the strain energy.
        point : SweepPoint, optional
            Circumstances of the sweep; unless given, a steady temperature, the laws' reference, at 1 V.

        Raises
        ------
        ValueError
            For an effect that is not in the library, and for one that depends on the strain energy before
            `referred` was called.
        """
        here = point or steady(laws)
        return self.states.at(
            here, laws, effects, frequency, self.settled_energy(here, laws, effects, effects, frequency)
        )

    def solved(self, state: PlateState, frequency: Real) -> LocalSolution:
        """Solve the plate in a state over frequencies (F,), Hz."""
        return LocalSolution.of(self.plate, self._whole(state), state, frequency, self.reach)

    def referred(self, laws: LocalLaws) -> Self:
        """Return the twin with strain energies relative to those at 25 degrees Celsius with these laws."""
        low, high = max(100.0, self.band[0]), min(1500.0, self.band[1])
        point = SweepPoint(REFERENCE_TEMPERATURE, 0.0, 1.0)

        def energies(lines: Real) -> Real:
            state = self.states.at(point, laws, {}, lines, np.ones(lines.size))
            return self._strain_energy(state, lambda _: state, lines, point, 1.0).at(np.zeros(lines.size))

        lines = np.linspace(low, high, 701)
        first = int(energies(lines).argmax())
        # resonances of sheet metals are narrower than the spacing of these lines
        near = np.linspace(lines[max(first - 1, 0)], lines[min(first + 1, 700)], 401)
        return replace(self, peak_energy=float(energies(near).max()))

    def counted(self, laws: Sequence[LocalLaws], effects: Iterable[str]) -> Self:
        """Return the twin referred to the laws nearest to 25 degrees Celsius, if an effect needs energies."""
        if not self.states.follow_energy(effects):
            return self
        return self.referred(min(laws, key=lambda law: abs(law.reference - REFERENCE_TEMPERATURE)))

    def settled_energy(
        self, point: SweepPoint, laws: LocalLaws, effects: StateEffects, asked: Iterable[str], frequency: Real
    ) -> Real:
        """Self-consistent strain energy for `Circumstances`.

        Parameters
        ----------
        effects : mapping
            Values of those that are on.
        asked : iterable of str
            Effects to be evaluated; if none depends on the energy, ones are returned.
        frequency : (F,) ndarray, Hz

        Returns
        -------
        (F,) ndarray

        Raises
        ------
        ValueError
            If the plate is not certified in that state, or before `referred` was called.
        """
        if not self.states.follow_energy(asked):
            return np.ones(frequency.size)

        def state_of(energy: NDArray[Any]) -> PlateState:
            return self.states.at(point, laws, effects, frequency, energy)

        linear = state_of(np.zeros(frequency.size))
        self.plate.require(linear)
        return self._strain_energy(linear, state_of, frequency, point, self.energy_scale(point)).settled()

    def energy_scale(self, point: SweepPoint) -> float:
        """Relative strain energy per J/V2; ValueError before `referred` was called."""
        if self.peak_energy is None:
            raise ValueError("strain energies have no reference yet: call `referred` first")
        return point.level**2 / self.peak_energy

    def _whole(self, state: PlateState) -> Composite:
        """Compose a state, with the footprints of transducers as further ports, and their masses."""
        whole = self.plate.composed(state)
        if not len(self.plate.footprints):
            return whole
        transducers = self._transducers(state)
        whole = replace(whole, coupling=np.hstack([whole.coupling, transducers.rows.T]))
        return replace(whole, mass=whole.mass + transducers.inertia) if transducers.masses.any() else whole

    def slopes(self, state: PlateState, basis: Real) -> CompositeSlopes:
        """Return derivatives of a state's matrices and ports in the coordinates of `basis` (r, m)."""
        own = self.plate.slopes(state, basis)
        if not len(self.plate.footprints):
            return own
        return TransducerSlopes(own, self._transducers(state).on(basis))

    def _transducers(self, state: PlateState) -> Transducers:
        declared = [one.mass for one in self.experiment.footprints] if self.experiment else []
        masses = np.array(declared or np.zeros(len(self.plate.footprints)))
        return Transducers.of(self.plate.footprints, self.plate.footprint_slopes, masses, state.departures)

    def _strain_energy(
        self, linear: PlateState, state_of: StateOf, frequency: Real, point: SweepPoint, scale: float
    ) -> StrainEnergy:
        if self.experiment is None:
            raise ValueError("this twin has no experiment that gives the plate its mass")
        local = LocalPlate.of(self.plate, self._whole(linear), linear, self.reach)
        plate = self.experiment.plate
        source = self.driven_at(point).source
        return StrainEnergy.of(local, source, state_of, frequency, scale=scale, density=plate.mass / plate.area)


def steady(laws: LocalLaws) -> SweepPoint:
    """Oven at rest at the laws' reference, 1 V."""
    return SweepPoint(laws.reference, 0.0, 1.0)
