"""States of an experiment's plate: effects of a library applied in order."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.effect_card import EffectCard
from analysis.experiment import Experiment
from analysis.local_laws import LocalLaws
from analysis.recordings.sweep_point import SweepPoint
from simulation.effects.effect import Effect
from simulation.effects.library import apply_all
from simulation.reduction.effect_operators import BENDING_DEGREE
from simulation.state.field_basis import field_basis
from simulation.state.plate_state import Circumstances, PlateState
from simulation.tolerances import Tolerance, depart

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
