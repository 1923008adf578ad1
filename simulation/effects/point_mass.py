"""Point mass: mass of a cable and its glue on the plate."""

from collections.abc import Mapping
from typing import Any

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState, PointLoad


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; the first centimetres of a thin cable and a drop of glue weigh about a gram."""
    return EffectCard(
        name="point_mass",
        summary="the cable adds its mass where it is fixed",
        parameters=(Parameter("mass", "kg", 0.0, 0.01, 0.001, shown="g"),),
        needs="modes that move the cable point and others that do not",
        separated_by="weigh cable and glue, or fix a known mass there and see whether the estimate grows by it",
        title="added mass at the cable",
        phrase="an added mass of {mass} at the cable",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Add the mass to the normal motion of the (first) cable point.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``mass``, kg.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    load = PointLoad(circumstances.cables[0], mass=values["mass"])
    return state.with_(point_loads=(*state.point_loads, load))


def available(experiment: Experiment) -> bool:
    """Whether a cable point is declared."""
    return bool(experiment.cable)


EFFECT = Effect(card, apply, available, "the [[cable]] whose mass it is")
