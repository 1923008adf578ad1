"""Fractional viscosity: a part of the loss grows as a power of frequency, and the modulus with it."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState

REFERENCE_FREQUENCY = 500.0  # Hz, at which the laws apply unchanged


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; polymers between their transitions have orders of 0.2 to 0.6."""
    return EffectCard(
        name="fractional_viscosity",
        summary="a share of the loss is that of a fractional dashpot, whose stiffness rises with frequency",
        parameters=(
            Parameter("share", "1", 0.0, 1.0, 0.3, shown="%"),
            Parameter("order", "1", 0.1, 1.0, 0.3, shape=True, typical=0.5),
        ),
        needs=("modes over at least two octaves, better with a loss factor that changes over temperature"),
        separated_by=(
            "a dynamic mechanical analysis of a strip; with an order towards 0 it is the viscoelastic_dispersion"
        ),
        sites=({"order": 0.25}, {"order": 0.5}, {"order": 0.8}),
        title="loss of a fractional dashpot",
        phrase="a share of {share} of the loss by a fractional dashpot of order {order}",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Modulus 1 + j eta (1 - share) + share eta (s**order (cot + j) - cot), s = f/500, cot = cot(pi order/2).

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``share`` of the loss factor at 500 Hz, and ``order`` of the derivative.

    Returns
    -------
    PlateState
        `state` with the effect.

    Notes
    -----
    The fractional Kelvin-Voigt model E_0 + E_1 (j w)**order (Bagley and Torvik, AIAA J. 21, 1983), whose modulus
    and loss at 500 Hz are those of the laws.
    """
    eta = state.laws.loss_factor(state.mean_temperature)
    order = values["order"]
    power = np.exp(order * np.log(circumstances.frequency / REFERENCE_FREQUENCY)) - 1.0
    spring = eta * np.cos(0.5 * np.pi * order) / np.sin(0.5 * np.pi * order)
    return state.with_(
        storage=state.storage * (1.0 + values["share"] * spring * power),
        loss=state.loss * (1.0 + values["share"] * power),
    )


EFFECT = Effect(card, apply)
