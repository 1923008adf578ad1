"""Elastic foundation: foam or a thin gap of air behind the plate pushes back, alike all over it."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; one prior sigma lets the plate bounce as a whole at the lower end of the band."""
    plate = experiment.plate
    usual = plate.mass / plate.area * (2.0 * np.pi * experiment.protocol.band[0]) ** 2
    return EffectCard(
        name="elastic_foundation",
        summary="foam or enclosed air behind the plate acts as a spring all over it",
        parameters=(Parameter("stiffness", "N/m3", 0.0, 25.0 * usual, usual, shown="N/cm³"),),
        needs="modes at the lower end of the band and others an octave higher",
        separated_by=("a sweep without foam, or with twice the distance to the wall: the stiffness of air halves"),
        title="spring behind the plate",
        phrase="a spring of {stiffness} all over the plate",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Add the stiffness per area to normal motion (Winkler's foundation).

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``stiffness``, N/m3; of a gap d of air that cannot escape, rho c**2/d.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    return state.with_(area_stiffness=state.area_stiffness + values["stiffness"])


EFFECT = Effect(card, apply)
