"""One sweep's state, and the same with a complex step of each parameter in turn."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real
from analysis.local_laws import LocalLaws
from analysis.sweep_point import SweepPoint
from analysis.twin_model import Linearisation, Tangent
from simulation.reduction.composition import COMPLEX_STEP
from simulation.state.plate_state import PlateState
from simulation.twin.derivatives import Derivatives
from simulation.twin.moved_patches import MOVE_SHARE
from simulation.twin.states import StateEffects, States


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
    moves_held : bool
        Whether patches stay where they are while other parameters are stepped.
    """

    states: States
    point: SweepPoint
    laws: LocalLaws
    effects: StateEffects
    frequency: Real
    moves_held: bool = False

    def state(self, energy: NDArray[np.generic]) -> PlateState:
        """Return the plate's state at relative strain energies (F,)."""
        found = self.states.at(self.point, self.laws, self.effects, self.frequency, energy)
        return found.with_(departures=found.departures.without_steps_of_moves()) if self.moves_held else found

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
        by_parameter = plain.by_parameter.copy()
        for k, there in zip(on, after.by_parameter, strict=True):
            stepped = replace(held, effects=self._stepped(tangents[k]))
            moving = replace(stepped, moves_held=False).state(here.energy).departures.stepped_moves
            before = here.by(stepped.state) if moving else plain.by_parameter[k]
            by_parameter[k] += (there - before) / MOVE_SHARE
        rates = {
            name: getattr(plain, name) + (getattr(after, name) - getattr(plain, name)) / MOVE_SHARE
            for name in ("by_material", "by_slope", "by_curvature", "by_temperature")
        }
        return Linearisation(
            transfer=plain.transfer + here.by(self.along_moves), by_parameter=by_parameter, **rates
        )

    def linearisation(self, derivatives: Derivatives, tangents: Sequence[Tangent]) -> Linearisation:
        """Differentiate the outputs by laws, temperature and the effects' parameters `tangents`."""
        response = derivatives.reading.response

        def by(**stepped: object) -> Complex:
            return derivatives.by(replace(self, **stepped).state)  # type: ignore[arg-type]

        here = self.state(derivatives.energy)
        if self.effects:
            by_material = [by(laws=self._moved(law)) for law in range(3)]
            warmer: complex = self.point.temperature + 1j * COMPLEX_STEP
            by_temperature = by(point=replace(self.point, temperature=warmer))  # type: ignore[arg-type]
        else:  # all damping is the plate's, (1 + j eta) E P, and temperature acts only through the laws
            by_modulus, by_ratio = (by(laws=self._moved(law)) for law in range(2))
            eta = 1j * float(here.laws.loss_factor(self.point.temperature))
            by_material = [by_modulus, by_ratio, eta / (1.0 + eta) * by_modulus]
            by_temperature = np.tensordot(here.laws.rates(self.point.temperature), by_material, 1)
        if np.ptp(here.temperature):
            by_slope = [by(laws=self._tilted(1j * COMPLEX_STEP * law, 0.0 * law)) for law in np.eye(3)]
            by_curvature = [by(laws=self._tilted(0.0 * law, 1j * COMPLEX_STEP * law)) for law in np.eye(3)]
        else:  # the laws are asked at one temperature only
            away = float(here.mean_temperature) - self.point.temperature
            by_slope, by_curvature = ([share * row for row in by_material] for share in (away, 0.5 * away**2))
        by_parameter = np.empty((len(tangents), *response.shape), complex)  # most of the memory: written in place
        for tangent, row in zip(tangents, by_parameter, strict=True):
            row[...] = by(effects=self._stepped(tangent))
        return Linearisation(
            transfer=response,
            by_material=np.array(by_material),
            by_slope=np.array(by_slope),
            by_curvature=np.array(by_curvature),
            by_temperature=by_temperature,
            by_parameter=by_parameter,
        )

    def _moved(self, law: int) -> LocalLaws:
        value = self.laws.value.astype(complex)
        value[law] += 1j * COMPLEX_STEP
        return replace(self.laws, value=value)

    def _tilted(self, slope: NDArray[Any], curvature: NDArray[Any]) -> LocalLaws:
        return self.laws.tilted(slope, curvature, self.point.temperature)

    def _stepped(self, tangent: Tangent) -> StateEffects:
        name, parameter, absent = tangent
        values = dict(self.effects.get(name, absent))
        return {**self.effects, name: {**values, parameter: values[parameter] + 1j * COMPLEX_STEP}}
