"""Permittivity drift: the patches' capacitance changes with temperature."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState

REFERENCE_TEMPERATURE = 25.0  # degrees Celsius, at which the permittivity is nominal


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; soft ceramics gain three to six thousandths of their capacitance per kelvin."""
    return EffectCard(
        name="permittivity_drift",
        summary="the capacitance of the patches grows with temperature",
        parameters=(Parameter("beta", "1/K", -0.01, 0.01, 0.004, shown="%/K"),),
        needs=("patches read as voltages over a wide temperature range with one gain, down to some 100 Hz"),
        separated_by=(
            "the patches' capacitance over temperature by an LCR meter; a piezo_drift leaves their phase alone"
        ),
        title="capacitance that drifts with temperature",
        phrase="a capacitance of the patches that changes by {beta}",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Multiply the permittivity of every patch by 1 + beta (T - 25).

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``beta``, 1/K.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    factor = 1.0 + values["beta"] * (state.mean_temperature - REFERENCE_TEMPERATURE)
    away = state.departures
    return state.with_(departures=replace(away, permittivity=away.permittivity * factor))


def available(experiment: Experiment) -> bool:
    """Return whether a patch is read as a voltage: the capacitance of others does not count."""
    return any(one.patch is not None and one.quantity == "voltage" for one in experiment.outputs)


EFFECT = Effect(card, apply, available, "a patch that is read as a voltage")
