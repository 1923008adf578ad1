"""Channel skew: the responses were sampled later than the drive."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; multiplexed channels are tens of microseconds apart, filters of two modules more."""
    return EffectCard(
        name="channel_skew",
        summary="the responses lag behind the drive by a constant time",
        parameters=(Parameter("delay", "s", -1e-3, 1e-3, 5e-5, shown="µs"),),
        needs="the phase of the responses over a wide band",
        separated_by="drive voltage fed to the sensors' inputs directly: the phase of that ratio is the skew",
        title="delay between drive and responses",
        phrase="the responses are recorded {delay} after the drive",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Multiply responses by exp(-j w delay): a positive delay makes them late.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``delay``, s.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    return state.with_(phase=state.phase - 2.0 * np.pi * circumstances.frequency * values["delay"])


EFFECT = Effect(card, apply)
