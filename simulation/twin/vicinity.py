"""One sweep's state, and the same with a complex step of each parameter in turn."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.local_laws import LocalLaws
from analysis.sweep_point import SweepPoint
from analysis.twin_model import Linearisation, Tangent
from simulation.reduction.composition import COMPLEX_STEP
from simulation.state.plate_state import PlateState
from simulation.twin.derivatives import Derivatives
from simulation.twin.moved_patches import MOVE_SHARE
from simulation.twin.states import StateEffects, States

Step = tuple[str | int, ...]


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
        step = self.step if energy is self.energy else None
        found = None if step is None else self.known.get(step)
        if found is None:
            found = self.states.at(self.point, self.laws, self.effects, self.frequency, energy)
            if step is not None:
                self.known[step] = found
        if not (self.moves_held and found.departures.stepped_moves):
            return found
        return found.with_(departures=found.departures.without_steps_of_moves())

    def along_moves(self, energy: NDArray[np.generic]) -> PlateState:
        """Return the state with an imaginary step along the moves of its patches."""
        state = self.state(energy)
        return state.with_(departures=state.departures.along_moves(1j * COMPLEX_STEP))

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
