"""Mounting resonance: accelerometers ride on the compliance of their wax, tape or magnet."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; wax holds up to some 10 kHz, tape to 5 kHz, a probe held by hand to 1 kHz."""
    return EffectCard(
        name="mounting_resonance",
        summary="accelerometers on a soft mount read too much at high frequencies",
        parameters=(Parameter("softness", "1", 0.0, 0.5, 0.05, shown="%"),),
        needs="accelerations over at least two octaves",
        separated_by="the same sweep with the accelerometer glued or screwed on",
        title="soft mount of the accelerometers",
        phrase="a mount of the accelerometers whose softness is {softness}",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Multiply responses by 1/(1 - softness (f/f_high)**2), f_high the upper end of the band.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``softness``, (f_high over the mounting resonance)**2.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    ratio = circumstances.frequency / circumstances.band[1]
    return state.with_(log_gain=state.log_gain - np.log(1.0 - values["softness"] * ratio**2))


def available(experiment: Experiment) -> bool:
    """Return whether accelerations are read, and nothing else."""
    return all(channel.quantity == "acceleration" for channel in experiment.outputs)


EFFECT = Effect(card, apply, available, nothing_missing=True)
