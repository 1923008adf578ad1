"""The digital twin: transfer from one input to all outputs, with or without effects, and derivatives.

Each parameter's derivative starts from a complex step of one sweep's state. The transfer is linear in the moves of
patches, H = H0 + D m for moves m, so that a derivative of H is that of H0 plus that of D times m. The latter is
the slope, along the moves, of the derivatives of a plate whose matrices follow them: a difference of two plates a
small share of the moves apart. Without it a fit that moves patches by tenths of a millimetre has derivatives that
are wrong by some per cent, takes three times the steps, and ends beside its minimum.

Recorded signals are outputs per unit of the input, with the factors, the feedthrough and the crosstalk of effects.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from analysis.arrays import Complex, Real
from analysis.material import LocalLaws
from analysis.recordings.sweep_point import SweepPoint
from analysis.twin_model import NO_EFFECTS, Effects, Linearisation, ModalParts, Tangent
from simulation.reduction.composition import COMPLEX_STEP, Composite
from simulation.reduction.modal_form import ModalSlopes
from simulation.reduction.reduced_model import certified_lines
from simulation.state.plate_state import SPECTRA, Departures, PlateState
from simulation.twin.instrumented_plate import InstrumentedPlate, Plate, StateEffects, States, steady
from simulation.twin.instruments import Instruments, Transfer
from simulation.twin.local_plate import CompositeSlopes, LocalPlate
from simulation.twin.local_solution import LineSolver, LocalSolution
from simulation.twin.sensitivity import EnergySlopes, ModalSensitivity, ParameterChange, TransferSensitivity
from simulation.twin.strain_energy import StateOf


@dataclass(frozen=True)
class SignalReading:
    """Instruments connected to a plate, and the factor and constant of effects on their signals.

    Attributes
    ----------
    transfer : Transfer
        Before that factor.
    factor : (K, F) complex ndarray
    electric : (K, 1) ndarray
        1 for voltages that follow a voltage, to which the feedthrough is added; else 0.
    response : (K, F) complex ndarray
        Transfer times factor, plus feedthrough and crosstalk.
    ports : int
        Of the plate.
    capacitance : (P,) ndarray, F
        Of the patches as declared.
    """

    transfer: Transfer
    factor: Complex
    electric: NDArray[np.float64]
    response: Complex
    ports: int
    capacitance: Real

    @classmethod
    def of(
        cls, solved: LocalSolution, state: PlateState, instruments: Instruments, capacitance: NDArray[np.float64]
    ) -> Self:
        """Read a solved plate.

        Parameters
        ----------
        solved : LocalSolution
            Its coupling has a column for each port.
        capacitance : (P,) ndarray, F
            Of the patches as declared.

        Returns
        -------
        SignalReading
        """
        between = solved.compliance(instruments.seen, instruments.driving)
        away = state.departures
        wired = instruments.wired(away.resistance, away.capacitance)
        transfer = Transfer.of(wired, _capacitance(capacitance, away), between, solved.frequency)
        sensitivity = np.reshape(away.log_sensitivity, (-1, 1))
        factor = np.exp(sensitivity + state.log_gain + 1j * state.phase)
        driven_by_voltage = instruments.source < capacitance.size
        electric = np.array([[float(one.voltage and driven_by_voltage)] for one in instruments.pickups])
        response = transfer.response * factor + electric * (state.feedthrough + 1j * state.crosstalk)
        return cls(transfer, factor, electric, response, solved.composite.coupling.shape[1], capacitance)

    @property
    def drive(self) -> Complex:
        """Of `Transfer.drive`, (ports, F)."""
        return self.transfer.drive(self.ports)

    @property
    def sense(self) -> Complex:
        """Of `Transfer.sense`, (K, ports, F)."""
        return self.transfer.sense(self.ports)

    def change(self, transfer: Complex, stepped: PlateState) -> Complex:
        """Differentiate `response`, (K, F), given that of the transfer (K, F) and the stepped state."""
        away = stepped.departures
        louder = np.reshape(np.imag(away.log_sensitivity), (-1, 1))
        turned = (louder + np.imag(stepped.log_gain) + 1j * np.imag(stepped.phase)) / COMPLEX_STEP
        if away.stepped:
            transfer = transfer + self._loaded(away)
        fed = self.electric * (np.imag(stepped.feedthrough) + 1j * np.imag(stepped.crosstalk)) / COMPLEX_STEP
        return np.asarray(self.factor * (transfer + self.transfer.response * turned) + fed)

    def _loaded(self, away: Departures) -> Complex:
        """Differentiate the transfer (K, F) by what is connected to the patches, given stepped departures."""
        wired = self.transfer.instruments
        capacitance = np.imag(_capacitance(self.capacitance, away)) / COMPLEX_STEP
        resistance = np.imag(away.resistance) / np.real(away.resistance) / COMPLEX_STEP
        inputs = np.imag(away.capacitance) / np.real(away.capacitance) / COMPLEX_STEP
        if not (wired.connected and (capacitance.any() or resistance or inputs)):
            return np.zeros_like(self.transfer.response)
        lines = self.transfer.frequency
        change = wired.across_change(capacitance, float(resistance), float(inputs), lines)
        # as a change of the charge on the connected ports at their present voltages
        felt = np.einsum("kcf,cf->kf", self.sense[:, list(wired.connected)], change * self.transfer.voltage)
        return np.asarray(felt)


def _capacitance(declared: Real, away: Departures) -> Any:
    """Capacitance (P,) of patches with other permittivities, areas and thicknesses, F."""
    return declared * (away.permittivity * away.patch_area / away.patch_thickness)


TOGETHER = 32
"""Parameters by which is differentiated at once: each holds four matrices of the plate, a megabyte."""


@dataclass(frozen=True)
class Derivatives:
    """Derivatives of the outputs at one state.

    Attributes
    ----------
    reading : SignalReading
        What is differentiated.
    slopes : CompositeSlopes
        Of the plate's matrices.
    sensitivity : TransferSensitivity or ModalSensitivity
        Of the transfer by these.
    energy : (F,) ndarray
        Relative strain energy of the state.
    by_energy : EnergySlopes or None
        Derivatives of that energy; None if no effect depends on it.
    """

    reading: SignalReading
    slopes: CompositeSlopes
    sensitivity: TransferSensitivity | ModalSensitivity
    energy: Real
    by_energy: EnergySlopes | None

    @classmethod
    def of(
        cls,
        slopes: CompositeSlopes,
        solved: LocalSolution,
        reading: SignalReading,
        state_of: StateOf,
        energy: Real,
        scale: float,
    ) -> Self:
        """Prepare derivatives at a solved state.

        Parameters
        ----------
        slopes : CompositeSlopes
            Of the plate's matrices at the state, in the coordinates of `solved`.
        solved : LocalSolution
            Of the state at `energy`.
        reading : SignalReading
            Of it.
        state_of : callable
            (F,) relative strain energy -> PlateState.
        energy : (F,) ndarray
        scale : float
            Relative energies per J/V2.
        """
        state, transfer = solved.state, reading.transfer
        sensitivity: TransferSensitivity | ModalSensitivity
        if solved.modal is None:
            sensitivity = TransferSensitivity.of(solved, state, reading.drive, reading.sense)
        else:
            ports, instruments = solved.composite.coupling, transfer.instruments
            seen, driving = ports[:, list(instruments.seen)], ports[:, list(instruments.driving)]
            modal = ModalSlopes.of(solved.modal, seen, driving, solved.frequency, solved.sums)
            sensitivity = ModalSensitivity(solved, state, transfer, modal)
        follower = state_of(energy + 1j * COMPLEX_STEP)
        by_energy = None
        if any(np.imag(getattr(follower, name)).any() for name in (*SPECTRA, "log_gain", "phase")):
            by_energy = EnergySlopes.of(solved, transfer.instruments.source, state, follower, scale)
        return cls(reading, slopes, sensitivity, energy, by_energy)

    def by_each(self, states_of: Sequence[StateOf]) -> Iterator[Complex]:
        """Differentiate the outputs, (K, F), by each parameter that has an imaginary step in one of `states_of`.

        Together they take a third of the time.
        """
        for first in range(0, len(states_of), TOGETHER):
            steps = [self._step(one) for one in states_of[first : first + TOGETHER]]
            changes = self.sensitivity.by_each(steps)
            for (_, stepped), change in zip(steps, changes, strict=True):
                yield self.reading.change(change, stepped)

    def _step(self, state_of: StateOf) -> ParameterChange:
        stepped = state_of(self.energy)
        moved = self.slopes.by(stepped)
        if self.by_energy:
            stepped = state_of(self.energy + 1j * COMPLEX_STEP * self.by_energy.by(moved, stepped))
        return moved, stepped


MOVE_SHARE = 1e-4
"""Share of the moves for the difference: it has an error of some parts of this share, and rounding of 1e-12 over
it. With 1e-2 derivatives were wrong by 0.4 %, and fits ended beside their minimum."""

NEAR_BAND = 1.3
"""Factor beyond the ends of the band up to which modes count as near it."""

Step = tuple[str | int, ...]


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


@dataclass(frozen=True)
class Vicinity:
    """Parameters that determine the state of a plate during one sweep.

    Attributes
    ----------
    states : States
    point : SweepPoint
    laws : LocalLaws
    effects : mapping
        Values of those that are on.
    frequency : (F,) ndarray
        Hz.
    energy : (F,) ndarray
        Relative strain energy, at which states are asked for again and again.
    moves_held : bool
        Whether patches stay where they are while other parameters are stepped.
    step : tuple or None
        What has a complex step; None where the state will not be asked for again.
    known : dict
        States at `energy` by that step.
    """

    states: States
    point: SweepPoint
    laws: LocalLaws
    effects: StateEffects
    frequency: Real
    energy: Real
    moves_held: bool = False
    step: Step | None = ()
    known: dict[Step, PlateState] = field(default_factory=dict, repr=False, compare=False)

    def state(self, energy: NDArray[np.generic]) -> PlateState:
        """Return the plate's state at relative strain energies (F,)."""
        found = self._once(
            energy,
            self.step,
            lambda: self.states.at(self.point, self.laws, self.effects, self.frequency, energy),
        )
        if not (self.moves_held and found.departures.stepped_moves):
            return found
        return found.with_(departures=found.departures.without_steps_of_moves())

    def along_moves(self, energy: NDArray[np.generic]) -> PlateState:
        """Return the state with an imaginary step along the moves of its patches."""
        state = self.state(energy)
        return self._once(
            energy,
            None if self.step is None else (*self.step, "moves"),
            lambda: state.with_(departures=state.departures.along_moves(1j * COMPLEX_STEP)),
        )

    def _once(self, energy: NDArray[np.generic], step: Step | None, make: Callable[[], PlateState]) -> PlateState:
        """Make a state; only once where it will be asked for again."""
        if step is None or energy is not self.energy:
            return make()
        if step not in self.known:
            self.known[step] = make()
        return self.known[step]

    def along(
        self, plain: Linearisation, here: Derivatives, moved: Derivatives, tangents: Sequence[Tangent]
    ) -> Linearisation:
        """Add to a linearisation what the moves of patches change.

        Parameters
        ----------
        plain : Linearisation
            Without them.
        here, moved : Derivatives
            Of the plate without them, and with a `MOVE_SHARE` of them.
        tangents : sequence of Tangent
            Of `plain`; those of effects that are off are left as they are.

        Returns
        -------
        Linearisation
        """
        held = replace(self, moves_held=True)
        on = [k for k, (name, _, _) in enumerate(tangents) if name in self.effects]
        after = held.linearisation(moved, [tangents[k] for k in on])
        by_parameter, before = plain.by_parameter.copy(), plain.by_parameter[on]
        stepped = [self._along_parameter(tangents[k]) for k in on]
        moving = [i for i, one in enumerate(stepped) if one.state(here.energy).departures.stepped_moves]
        *stand, by_moves = here.by_each(
            [*(replace(stepped[i], moves_held=True).state for i in moving), self.along_moves]
        )
        for i, change in zip(moving, stand, strict=True):
            before[i] = change
        by_parameter[on] += (after.by_parameter - before) / MOVE_SHARE
        rates = {
            name: getattr(plain, name) + (getattr(after, name) - getattr(plain, name)) / MOVE_SHARE
            for name in ("by_material", "by_slope", "by_curvature", "by_temperature")
        }
        return Linearisation(transfer=plain.transfer + by_moves, by_parameter=by_parameter, **rates)

    def linearisation(self, derivatives: Derivatives, tangents: Sequence[Tangent]) -> Linearisation:
        """Differentiate the outputs by laws, temperature and the effects' parameters `tangents`."""
        response = derivatives.reading.response
        here = self.state(derivatives.energy)
        stepped = [self._along_law(law) for law in range(3 if self.effects else 2)]
        if self.effects:
            warmer: complex = self.point.temperature + 1j * COMPLEX_STEP
            point = replace(self.point, temperature=warmer)  # type: ignore[arg-type]
            stepped.append(replace(self, point=point, step=("temperature",)))
        spread = bool(np.ptp(here.temperature))
        if spread:
            stepped += [self._along_tilt(law, order) for order in (1, 2) for law in range(3)]
        of_laws = len(stepped)
        stepped += [self._along_parameter(tangent) for tangent in tangents]
        by_each = derivatives.by_each([one.state for one in stepped])
        laws = [next(by_each) for _ in range(of_laws)]
        if self.effects:
            by_material, by_temperature = laws[:3], laws[3]
        else:  # all damping is the plate's, (1 + j eta) E P, and temperature acts only through the laws
            eta = 1j * float(here.laws.loss_factor(self.point.temperature))
            by_material = [*laws[:2], eta / (1.0 + eta) * laws[0]]
            by_temperature = np.tensordot(here.laws.rates(self.point.temperature), by_material, 1)
        if spread:
            by_slope, by_curvature = laws[-6:-3], laws[-3:]
        else:  # the laws are asked at one temperature only
            away = float(here.mean_temperature) - self.point.temperature
            by_slope, by_curvature = ([share * row for row in by_material] for share in (away, 0.5 * away**2))
        by_parameter = np.empty((len(tangents), *response.shape), complex)  # most of the memory: written in place
        for row, change in zip(by_parameter, by_each, strict=True):
            row[...] = change
        return Linearisation(
            transfer=response,
            by_material=np.array(by_material),
            by_slope=np.array(by_slope),
            by_curvature=np.array(by_curvature),
            by_temperature=by_temperature,
            by_parameter=by_parameter,
        )

    def _along_law(self, law: int) -> "Vicinity":
        value = self.laws.value.astype(complex)
        value[law] += 1j * COMPLEX_STEP
        return replace(self, laws=replace(self.laws, value=value), step=("law", law))

    def _along_tilt(self, law: int, order: int) -> "Vicinity":
        """Return it with a complex step of a law's slope over temperature, or of its curvature."""
        step = 1j * COMPLEX_STEP * np.eye(3)[law]
        slope, curvature = (step, 0.0 * step) if order == 1 else (0.0 * step, step)
        return replace(
            self, laws=self.laws.tilted(slope, curvature, self.point.temperature), step=("tilt", law, order)
        )

    def _along_parameter(self, tangent: Tangent) -> "Vicinity":
        name, parameter, absent = tangent
        values = dict(self.effects.get(name, absent))
        effects = {**self.effects, name: {**values, parameter: values[parameter] + 1j * COMPLEX_STEP}}
        # what is off moves no patch: its state is needed once, and a screening asks for hundreds
        return replace(self, effects=effects, step=(name, parameter) if name in self.effects else None)


@dataclass(frozen=True)
class Twin(InstrumentedPlate[Plate]):
    """Transfer from the input named in a sweep's circumstances to K outputs, in their units.

    See `analysis.twin_model.TwinModel`, and `InstrumentedPlate` for the attributes.
    """

    def frf(
        self, laws: LocalLaws, frequency: ArrayLike, effects: Effects = NO_EFFECTS, point: SweepPoint | None = None
    ) -> Complex:
        """Return the outputs per unit of the input.

        Parameters
        ----------
        frequency : (F,) array_like, Hz
        effects : mapping
            Values of those that are on.
        point : SweepPoint, optional
            Circumstances of the sweep; unless given, a steady temperature, the laws' reference, at 1 V.

        Returns
        -------
        (K, F) complex ndarray

        Raises
        ------
        ValueError
            Outside the box or the band, for an effect's value outside its certified range, and for an effect that
            follows the strain energy before `referred` was called.
        """
        lines = certified_lines(frequency, self.band)
        return self.uncertified_frf(laws, lines, effects, point)

    def uncertified_frf(
        self, laws: LocalLaws, frequency: ArrayLike, effects: Effects = NO_EFFECTS, point: SweepPoint | None = None
    ) -> Complex:
        """Return the same as `frf`, also at frequencies outside the certified band.

        Parameters
        ----------
        frequency : (F,) array_like, Hz
        effects : mapping
            Values of those that are on.
        point : SweepPoint, optional
            As in `frf`.

        Returns
        -------
        (K, F) complex ndarray

        Raises
        ------
        ValueError
            As `frf`, but lines outside the band are allowed.
        """
        lines = np.atleast_1d(np.asarray(frequency, float))
        here = point or steady(laws)
        if here.drifts or self.state(laws, lines, effects, here).departures.moves:
            return self._linearised(laws, lines, effects, here, ()).transfer
        state = self.state(laws, lines, effects, here)
        self.plate.require(state)
        return self._reading(self.solved(state, lines), here).response

    def linearise(
        self,
        laws: LocalLaws,
        frequency: ArrayLike,
        effects: Effects = NO_EFFECTS,
        point: SweepPoint | None = None,
        tangents: Sequence[Tangent] = (),
    ) -> Linearisation:
        """Transfer and its derivatives, see `analysis.twin_model.TwinModel`.

        If the temperature drifts while the sweep passes, the transfer at each frequency is that at the temperature
        then, to first order. A sweep of 2 s on a ramp of 1 K/min drifts by 0.03 K, which changes a resonance of
        polypropylene by 0.7 % of its peak; what the first order leaves is 2e-5 of it. The derivatives are those at
        the mean temperature. Likewise the transfer is linear in the moves of patches, see `Departures`; its
        derivatives contain them, but for those of effects that are off.

        Parameters
        ----------
        frequency : (F,) array_like, Hz
        effects : mapping
            Values of those that are on.
        point : SweepPoint, optional
            Circumstances of the sweep; unless given, a steady temperature, the laws' reference, at 1 V.
        tangents : sequence of Tangent
            Parameters of effects by which to differentiate.

        Raises
        ------
        ValueError
            Outside the box or the band, for an effect's value outside its certified range, and for an effect that
            follows the strain energy before `referred` was called.
        """
        lines = certified_lines(frequency, self.band)
        return self._linearised(laws, lines, effects, point or steady(laws), tangents)

    def _linearised(
        self, laws: LocalLaws, lines: Real, effects: Effects, here: SweepPoint, tangents: Sequence[Tangent]
    ) -> Linearisation:
        """Linearise at lines inside the certified band or outside."""
        on = [*effects, *(name for name, _, _ in tangents)]
        energy = self.settled_energy(here, laws, effects, on, lines)
        vicinity = Vicinity(self.states, here, laws, effects, lines, energy)
        state = vicinity.state(energy)
        self.plate.require(state)
        solved = self.solved(state, lines)
        scale = self.energy_scale(here) if self.states.follow_energy(on) else 1.0
        slopes = self.slopes(state, solved.basis)
        derivatives = Derivatives.of(slopes, solved, self._reading(solved, here), vicinity.state, energy, scale)
        found = vicinity.linearisation(derivatives, tangents)
        if state.departures.moves:
            along = slopes.by(vicinity.along_moves(energy))
            moved = MovedPatches.of(solved, slopes, along)
            there = Derivatives.of(
                moved, moved.solved, self._reading(moved.solved, here), vicinity.state, energy, scale
            )
            found = vicinity.along(found, derivatives, there, tangents)
        if not here.drifts:
            return found
        return replace(found, transfer=found.transfer + here.drift(lines) * found.by_temperature)

    def modal_parts(
        self, laws: LocalLaws, frequency: ArrayLike, effects: Effects = NO_EFFECTS, point: SweepPoint | None = None
    ) -> ModalParts:
        """Parts of modes, see `analysis.twin_model.TwinModel`; of the plate without what is attached to it."""
        lines, here = certified_lines(frequency, self.band), point or steady(laws)
        energy = self.settled_energy(here, laws, effects, list(effects), lines)
        state = Vicinity(self.states, here, laws, effects, lines, energy).state(energy)
        solved = self.solved(state, lines)
        reading = self._reading(solved, here)
        form = solved.modal or LineSolver.of(solved.plate, state, lines).modes
        angular = np.sqrt(np.abs(form.poles.real)) / (2.0 * np.pi)
        count = int(np.searchsorted(angular, NEAR_BAND * lines[-1]))
        near = np.flatnonzero(angular[:count] > lines[0] / NEAR_BAND)
        coupling = solved.composite.coupling
        seen, driven = coupling.T @ form.shapes[:, near], form.inverse[near] @ coupling
        terms = 1.0 / (form.poles[near, None] - (2.0 * np.pi * lines) ** 2)
        parts = np.zeros((count, *reading.response.shape), complex)
        heard = np.einsum("kpf,pm->mkf", reading.sense, seen, optimize=True)
        parts[near] = heard * ((driven @ reading.drive) * terms)[:, None] * reading.factor
        return ModalParts(form.poles[:count], parts, lines)

    def _reading(self, solved: LocalSolution, point: SweepPoint) -> SignalReading:
        return SignalReading.of(solved, solved.state, self.driven_at(point), self.plate.capacitance)
