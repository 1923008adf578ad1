"""Mass at a place: something that nobody declared adds its mass where it sits."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import CLOSER_SITES, SITES, Effect, coordinates, sites
from simulation.state.plate_state import Attached, Circumstances, PlateState


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; a sensor, a clip or a blob of glue of a tenth of a gram to some grams."""
    places = sites(experiment, SITES)
    return EffectCard(
        name="mass_at_place",
        summary="an undeclared mass sits somewhere on the plate",
        parameters=(Parameter("mass", "kg", 0.0, 0.05, 0.001, shown="g"), *coordinates(experiment)),
        needs="modes that move the place and others that do not, better with several sensors",
        separated_by=("look there, and weigh what is found; a local_damage lowers other modes at the same place"),
        sites=tuple({"x": float(x), "y": float(y)} for x, y in places),
        closer_sites=tuple({"x": float(x), "y": float(y)} for x, y in sites(experiment, CLOSER_SITES)),
        title="undeclared mass",
        phrase="an added mass of {mass} at x {x}, y {y}",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Add the mass to the normal motion of the place.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``mass``, kg, ``x`` and ``y``, m.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    omega = 2.0 * np.pi * circumstances.frequency
    one = Attached(values["x"], values["y"], -(omega**2) * values["mass"], 0.0 * omega)
    return state.with_(attached=(*state.attached, one))


EFFECT = Effect(card, apply)
