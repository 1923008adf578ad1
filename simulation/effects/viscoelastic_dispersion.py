"""Viscoelastic dispersion: a lossy modulus rises with frequency, as causality requires."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState

REFERENCE_FREQUENCY = 500.0  # Hz, at which the laws apply unchanged


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; 1 follows from the Kramers-Kronig relations for a constant loss factor."""
    return EffectCard(
        name="viscoelastic_dispersion",
        summary="the modulus rises with frequency as much as its loss factor demands",
        parameters=(Parameter("kappa", "1", 0.0, 3.0, 1.0),),
        needs="modes over at least two octaves, better with a loss factor that changes over temperature",
        separated_by="a dynamic mechanical analysis of a strip; a sweep in vacuum or helium rules out the air",
        title="modulus that rises with frequency",
        phrase="the modulus rises with frequency, {kappa} times as much as its loss factor demands",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Multiply the complex modulus by (f/500)**(2 kappa eta/pi).

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``kappa``, 1 for the local relation below.

    Returns
    -------
    PlateState
        `state` with the effect.

    Notes
    -----
    The local Kramers-Kronig relation: dln|E|/dln f = 2 delta/pi with the loss angle delta, here eta (Booij and
    Thoone, Rheologica Acta 21, 1982). eta is that of the laws at the plate's mean temperature.
    """
    eta = state.laws.loss_factor(state.mean_temperature)
    factor = np.exp(2.0 / np.pi * values["kappa"] * eta * np.log(circumstances.frequency / REFERENCE_FREQUENCY))
    return state.with_(storage=state.storage * factor, loss=state.loss * factor)


EFFECT = Effect(card, apply)
