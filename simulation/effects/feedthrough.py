"""Feedthrough: a part of the drive reaches the inputs past the plate."""

from collections.abc import Mapping
from typing import Any

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; tens of picofarads between cables beside ten nanofarads of patch."""
    return EffectCard(
        name="feedthrough",
        summary="the drive leaks into every response, alike at all frequencies",
        parameters=(Parameter("gain", "V/V", -0.05, 0.05, 0.001, shown="%"),),
        needs="responses between resonances, where the plate's own are small",
        separated_by="a free patch on the same cables in place of the sensor: what it still reads is feedthrough",
        title="drive signal that leaks into the responses",
        phrase="{gain} of the drive leaks into every response",
    )


def available(experiment: Experiment) -> bool:
    """Return whether a voltage is read while a voltage drives."""
    return all(any(c.quantity == "voltage" for c in way) for way in (experiment.inputs, experiment.outputs))


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Add a real constant to the ratio of every sensor voltage to the actuator's; other transfers have none.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``gain``, V/V.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    return state.with_(feedthrough=state.feedthrough + values["gain"])


EFFECT = Effect(card, apply, available, "a voltage that drives and one that is read")
