"""Depolarization: heat has taken a part of the patches' polarization, so that the way down is weaker."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; below half of the Curie temperature a few per cent go in the first heating."""
    return EffectCard(
        name="depolarization",
        summary="all responses are weaker on the way down than on the way up",
        parameters=(Parameter("lost", "1", 0.0, 0.5, 0.03, shown="%"),),
        needs="an up and a down ramp over the same temperatures, recorded with one gain",
        separated_by=(
            "sweeps at room temperature before and after; an annealing of the plate moves resonances, too"
        ),
        title="patches that have lost polarization",
        phrase="responses that are weaker by {lost} on the way down",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Multiply responses by 1 - lost while the oven cools down.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``lost``, the share of the gain.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    if circumstances.point.rate >= 0.0:
        return state
    return state.with_(log_gain=state.log_gain + np.log(1.0 - values["lost"]))


def available(experiment: Experiment) -> bool:
    """Return whether a patch drives the plate or is read."""
    return any(channel.patch is not None for channel in (*experiment.inputs, *experiment.outputs))


EFFECT = Effect(card, apply, available, "a patch that drives or is read")
