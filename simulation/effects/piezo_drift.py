"""Piezo drift: the patches' coupling, or their electronics' gain, changes with temperature."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState

REFERENCE_TEMPERATURE = 25.0  # degrees Celsius, at which the gain is nominal


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate.

    Soft ceramics change by one or two thousandths per kelvin. Half a per cent is more than any does, and keeps
    the factor positive over all temperatures that may be declared.
    """
    return EffectCard(
        name="piezo_drift",
        summary="all responses grow or shrink with the oven's temperature",
        parameters=(Parameter("alpha", "1/K", -0.005, 0.005, 0.0015, shown="%/K"),),
        needs="a wide temperature range recorded with one gain: a gain of its own per temperature absorbs it",
        separated_by="the patches' capacitance over temperature, or inputs driven directly at each temperature",
        title="patches whose sensitivity drifts with temperature",
        phrase="all responses change by {alpha}",
    )


def available(experiment: Experiment) -> bool:
    """Return whether a patch drives the plate or is read."""
    return any(channel.patch is not None for channel in (*experiment.inputs, *experiment.outputs))


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Multiply responses by 1 + alpha (T_oven - 25).

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``alpha``, 1/K.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    warmer = circumstances.point.temperature - REFERENCE_TEMPERATURE
    return state.with_(log_gain=state.log_gain + np.log(1.0 + values["alpha"] * warmer))


EFFECT = Effect(card, apply, available, "a patch that drives or is read")
