"""Cable stiffness: a stiff cable holds the plate where it is fixed."""

from collections.abc import Mapping
from typing import Any

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState, PointLoad


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; a coaxial cable of 2 mm clamped 30 mm away gives hundreds of N/m."""
    return EffectCard(
        name="cable_stiffness",
        summary="the cable holds the plate by a spring and a dashpot where it is fixed",
        parameters=(
            Parameter("stiffness", "N/m", 0.0, 5000.0, 300.0, shown="N/mm"),
            Parameter("damping", "N s/m", 0.0, 10.0, 0.3),
        ),
        needs="modes at the lower end of the band that move the cable point",
        separated_by="a longer loop of cable; a point_mass lowers high modes, a spring raises low ones",
        title="stiffness of the cable",
        phrase="a cable that holds the plate with {stiffness} and brakes it with {damping}",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Add spring and dashpot to the normal motion of the (first) cable point.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``stiffness``, N/m, and ``damping``, N s/m.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    load = PointLoad(circumstances.cables[0], stiffness=values["stiffness"], damping=values["damping"])
    return state.with_(point_loads=(*state.point_loads, load))


def available(experiment: Experiment) -> bool:
    """Whether a cable point is declared."""
    return bool(experiment.cable)


EFFECT = Effect(card, apply, available, "the [[cable]] that holds")
