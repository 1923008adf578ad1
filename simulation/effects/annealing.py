"""Annealing: heat, drying or ageing make the plate stiffer or lossier on the way down."""

from collections.abc import Mapping
from typing import Any

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; fresh injection moulded polymers stiffen by some per cent, moist ones by tens."""
    return EffectCard(
        name="annealing",
        summary="the plate is stiffer or lossier on the way down than on the way up",
        parameters=(
            Parameter("stiffening", "1", -0.2, 0.5, 0.03, shown="%"),
            Parameter("loss", "1", -0.8, 1.0, 0.1, shown="%"),
        ),
        needs="an up and a down ramp over the same temperatures",
        separated_by=(
            "repeat the ramp: annealing does not come again; a thermal_lag goes with the slope of E(T) and "
            "the ramp's rate"
        ),
        title="plate that anneals",
        phrase="a plate that is stiffer by {stiffening} and lossier by {loss} on the way down",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Modulus times 1 + stiffening and loss factor times 1 + loss while the oven cools down.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``stiffening`` and ``loss``, relative.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    if circumstances.point.rate >= 0.0:
        return state
    stiffer = 1.0 + values["stiffening"]
    return state.with_(storage=state.storage * stiffer, loss=state.loss * stiffer * (1.0 + values["loss"]))


EFFECT = Effect(card, apply)
