"""Piezo loss: the ceramic's strain follows its field by a constant angle."""

from collections.abc import Mapping
from typing import Any

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; soft ceramics lose one to four hundredths in the strain constant d31."""
    return EffectCard(
        name="piezo_loss",
        summary="all responses lag by the same angle at every frequency",
        parameters=(Parameter("angle", "rad", 0.0, 0.2, 0.02, shown="mrad"),),
        needs="the phase of the responses over a wide band",
        separated_by=(
            "the loss tangent of a free patch by an LCR meter; a delay grows with frequency, an angle does not"
        ),
        title="loss of the patches' coupling",
        phrase="responses that lag by {angle} at every frequency",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Multiply responses by exp(-j angle).

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``angle``, rad: of all patches that a response passes together.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    return state.with_(phase=state.phase - values["angle"])


def available(experiment: Experiment) -> bool:
    """Return whether a patch drives the plate or is read."""
    return any(channel.patch is not None for channel in (*experiment.inputs, *experiment.outputs))


EFFECT = Effect(card, apply, available, "a patch that drives or is read")
