"""Damping dispersion: the loss factor changes over frequency."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState

REFERENCE_FREQUENCY = 500.0  # Hz, at which the laws apply unchanged


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; viscous friction is p = 1, a relaxation far below the band p = -1."""
    return EffectCard(
        name="damping_dispersion",
        summary="the loss factor follows a power of frequency",
        parameters=(Parameter("p", "1", -1.0, 1.0, 0.3),),
        needs="well separated modes over at least two octaves",
        separated_by="a dynamic mechanical analysis of a strip; softer strings rule out friction where it hangs",
        title="loss factor that changes with frequency",
        phrase="the loss factor goes with frequency to the power of {p}",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Loss factor eta (f/500)**p; the storage modulus is not changed.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``p``, the exponent.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    factor = np.exp(values["p"] * np.log(circumstances.frequency / REFERENCE_FREQUENCY))
    return state.with_(loss=state.loss * factor)


EFFECT = Effect(card, apply)
