"""Size of the spot that has lost stiffness: `local_damage` has a size of its own, a real spot another."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.effects.local_damage import RADIUS, available
from simulation.state.plate_state import Circumstances, PlateState

LEAST, MOST = -0.006, 0.028  # m, more than the radius of `local_damage`
PRIOR = 0.008  # m


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate, which is one beside `local_damage` only."""
    return EffectCard(
        name="damage_size",
        summary=f"the spot that has lost stiffness is not {2e3 * RADIUS:g} mm across",
        parameters=(Parameter("wider", "m", LEAST, MOST, PRIOR, shown="mm"),),
        needs="modes whose half-waves are not much longer than the spot",
        separated_by="a tap test or an ultrasonic scan around the place found",
        title="size of the spot",
        phrase=f"the radius of the spot is {1e3 * RADIUS:g} mm and {{wider}}",
        after="local_damage",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Widen the spots of `state`.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``wider``, m, is added to their radius.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    discs = tuple(replace(disc, radius=disc.radius + values["wider"]) for disc in state.discs)
    return state.with_(discs=discs)


EFFECT = Effect(card, apply, available, "a plate with space for the spot")
