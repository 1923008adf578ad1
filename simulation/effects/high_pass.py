"""High pass: the inputs are coupled through a capacitor or a conditioner."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; input modules' couplings end at a few hertz, conditioners' filters at some tens."""
    return EffectCard(
        name="high_pass",
        summary="a first-order high pass weakens and advances the responses at low frequencies",
        parameters=(Parameter("corner", "Hz", 0.0, 100.0, 10.0),),
        needs="responses near the lower end of the band",
        separated_by="drive voltage fed to the sensors' inputs directly, swept down to a few hertz",
        title="high pass in the measuring chain",
        phrase="a high pass at {corner} in the measuring chain",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Multiply responses by j f/(j f + corner) = 1/(1 - j corner/f).

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``corner``, Hz.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    ratio = values["corner"] / circumstances.frequency
    return state.with_(
        log_gain=state.log_gain - 0.5 * np.log(1.0 + ratio**2),
        phase=state.phase + np.arctan(ratio),
    )


EFFECT = Effect(card, apply)
