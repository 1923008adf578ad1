"""Insulation leak: charge drains from the patches through moist or warm insulation, more the warmer it is."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState

REFERENCE_TEMPERATURE = 25.0  # degrees Celsius, at which the leak is given


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; one that does not grow with temperature is the tolerance of the inputs."""
    return EffectCard(
        name="insulation_leak",
        summary="insulation beside the inputs leaks, more the warmer it is",
        parameters=(
            Parameter("leak25", "1", 0.0, 2.0, 0.05, shown="%"),
            Parameter("growth", "1/K", 0.01, 0.1, 0.03, shape=True, typical=0.05, shown="%/K", only_inside=True),
        ),
        needs=("patches read as voltages, responses near the lower end of the band, a wide temperature range"),
        separated_by=(
            "the resistance of cable and patch by a megohmmeter over temperature; a high_pass is alike at "
            "all temperatures"
        ),
        sites=({"growth": 0.03}, {"growth": 0.07}),
        title="leaking insulation",
        phrase="an insulation that leaks {leak25} of what the input does at 25 °C, growing by {growth}",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Resistance of the inputs over 1 + leak25 exp(growth (T - 25)).

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``leak25``, input resistance over that of the leak at 25 °C, and ``growth``, 1/K.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    warmer = state.mean_temperature - REFERENCE_TEMPERATURE
    leak = values["leak25"] * np.exp(values["growth"] * warmer)
    away = state.departures
    return state.with_(departures=replace(away, resistance=away.resistance / (1.0 + leak)))


def available(experiment: Experiment) -> bool:
    """Return whether a patch is read as a voltage."""
    return any(one.patch is not None and one.quantity == "voltage" for one in experiment.outputs)


EFFECT = Effect(card, apply, available, "a patch that is read as a voltage")
