"""Dashpot at a place: something that nobody declared brakes the plate."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import SITES, Effect, coordinates, sites
from simulation.state.plate_state import Attached, Circumstances, PlateState


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; a sponge or a finger that touches brakes by tenths of N s/m."""
    places = sites(experiment, SITES)
    return EffectCard(
        name="dashpot_at_place",
        summary="something undeclared brakes the plate somewhere by friction",
        parameters=(Parameter("damping", "N s/m", 0.0, 20.0, 0.3), *coordinates(experiment)),
        needs="modes whose loss factors differ, and that move the place, better with several sensors",
        separated_by="look there; hold a finger there and see whether the same modes lose more",
        sites=tuple({"x": float(x), "y": float(y)} for x, y in places),
        title="undeclared friction at a place",
        phrase="a friction of {damping} at x {x}, y {y}",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Add the dashpot to the normal motion of the place.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``damping``, N s/m, ``x`` and ``y``, m.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    omega = 2.0 * np.pi * circumstances.frequency
    one = Attached(values["x"], values["y"], 0.0 * omega, omega * values["damping"])
    return state.with_(attached=(*state.attached, one))


EFFECT = Effect(card, apply)
