"""String mass: knots, hooks and tape add their mass where strings hold the plate."""

from collections.abc import Mapping
from typing import Any

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState, PointLoad


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; tape with a hook weighs some tenths of a gram."""
    return EffectCard(
        name="string_mass",
        summary="tape, hooks or knots add their mass where the strings hold the plate",
        parameters=(Parameter("mass", "kg", 0.0, 0.01, 0.0005, shown="g"),),
        needs="modes that move the string points and others that do not",
        separated_by="weigh them; a suspension raises low modes, a mass lowers high ones",
        title="mass at the strings",
        phrase="an added mass of {mass} at each string",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Add the same mass to the normal motion of each declared string point.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``mass``, kg, at each string.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    loads = tuple(PointLoad(point, mass=values["mass"]) for point in circumstances.strings)
    return state.with_(point_loads=state.point_loads + loads)


def available(experiment: Experiment) -> bool:
    """Whether strings are declared."""
    return bool(experiment.string)


EFFECT = Effect(card, apply, available, "each [[string]] that holds the plate")
