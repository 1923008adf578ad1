"""Low pass: an amplifier charges the patches through its output resistance, so that their voltage is late."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; a kilohm before 30 nF of patches makes 30 microseconds, a corner of 5 kHz."""
    return EffectCard(
        name="low_pass",
        summary="a first-order low pass weakens and delays the responses at high frequencies",
        parameters=(Parameter("time_constant", "s", 0.0, 1e-3, 3e-5, shown="µs"),),
        needs="responses at the upper end of the band",
        separated_by=(
            "the drive voltage measured at the patch itself; a channel_skew delays alike but does not weaken"
        ),
        title="low pass of the electronics",
        phrase="a low pass with a time constant of {time_constant}",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Multiply responses by 1/(1 + j w time_constant).

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``time_constant``, s; the corner is 1/(2 pi time_constant).

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    ratio = 2.0 * np.pi * circumstances.frequency * values["time_constant"]
    return state.with_(
        log_gain=state.log_gain - 0.5 * np.log(1.0 + ratio**2),
        phase=state.phase - np.arctan(ratio),
    )


EFFECT = Effect(card, apply)
