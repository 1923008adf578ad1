"""Suspension: springs and dashpots of the strings."""

from collections.abc import Mapping
from typing import Any

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState, PointLoad


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; rubber bands give tens of N/m, taut nylon hundreds, short clamps thousands."""
    return EffectCard(
        name="suspension",
        summary="the strings hold the plate stiffly enough to be felt",
        parameters=(
            Parameter("stiffness", "N/m", 0.0, 5000.0, 300.0, shown="N/mm"),
            Parameter("damping", "N s/m", 0.0, 10.0, 0.5),
        ),
        needs="modes at the lower end of the band that move the string points",
        separated_by="hang the plate on longer or softer strings and see the lowest modes fall",
        title="stiff strings",
        phrase="each string holds the plate with {stiffness} and damps it with {damping}",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Add the same spring and dashpot to the normal motion of each declared string point.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``stiffness``, N/m, and ``damping``, N s/m, of each string.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    loads = tuple(
        PointLoad(point, stiffness=values["stiffness"], damping=values["damping"])
        for point in circumstances.strings
    )
    return state.with_(point_loads=state.point_loads + loads)


def available(experiment: Experiment) -> bool:
    """Whether strings are declared."""
    return bool(experiment.string)


EFFECT = Effect(card, apply, available, "each [[string]] that holds the plate")
