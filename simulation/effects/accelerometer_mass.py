"""Accelerometer mass: sensors that were declared without a mass load the plate where they sit."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState, unweighed


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; miniature accelerometers weigh half a gram to five grams, wax and cable more."""
    return EffectCard(
        name="accelerometer_mass",
        summary="accelerometers that were declared without a mass load the plate",
        parameters=(Parameter("mass", "kg", 0.0, 0.05, 0.002, shown="g"),),
        needs="modes that move the sensors and others that do not",
        separated_by="weigh the sensor with its wax; a declared mass has a tolerance and needs no effect",
        title="mass of the accelerometers",
        phrase="an added mass of {mass} at each accelerometer",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Add the same mass to every accelerometer declared without one.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``mass``, kg, of each.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    away = state.departures
    added = away.added_mass + values["mass"] * circumstances.unweighed
    return state.with_(departures=replace(away, added_mass=added))


def available(experiment: Experiment) -> bool:
    """Whether an accelerometer at one point is declared without a mass."""
    return bool(unweighed(experiment).any())


EFFECT = Effect(card, apply, available, nothing_missing=True)
