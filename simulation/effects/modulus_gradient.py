"""Modulus gradient: the plate is stiffer at one side than at the other by the same factor at every temperature."""

from collections.abc import Mapping
from typing import Any

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; crystallinity, fibre content or the way from the mould's gate make some per cent."""
    return EffectCard(
        name="modulus_gradient",
        summary="the material is stiffer at one side than at the other, alike at all temperatures",
        parameters=(
            Parameter("ex", "1", -0.15, 0.15, 0.03, shown="%"),
            Parameter("ey", "1", -0.15, 0.15, 0.03, shown="%"),
        ),
        needs=(
            "modes of several half-waves along both axes; a wide temperature range tells it from a "
            "draught_gradient"
        ),
        separated_by=(
            "strips cut from both sides; thermocouples rule out a draught_gradient, a thickness gauge a "
            "thickness_taper"
        ),
        title="material stiffer at one side",
        phrase="a modulus that changes by {ex} along x and {ey} along y",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """All moduli times 1 + ex xi + ey zeta.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``ex`` and ``ey``, relative, at the right and upper side.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    return state.with_(modulus=state.modulus * (1.0 + values["ex"] * state.xi + values["ey"] * state.zeta))


EFFECT = Effect(card, apply)
