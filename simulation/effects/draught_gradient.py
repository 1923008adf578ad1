"""Draught gradient: one side of the plate is warmer than the other, by the same amount at every temperature."""

from collections.abc import Mapping
from typing import Any

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; a leaking seal or the fan's own heat makes a kelvin."""
    return EffectCard(
        name="draught_gradient",
        summary="one side of the plate is warmer than the other by the same difference at every temperature",
        parameters=(Parameter("gx", "K", -7.0, 7.0, 1.0), Parameter("gy", "K", -7.0, 7.0, 1.0)),
        needs="temperatures at which the modulus is steep and others at which it is flat",
        separated_by="thermocouples at the plate's four corners; a thickness gauge at its edges rules out a taper",
        title="one side warmer at every temperature",
        phrase="at every temperature the right side is {gx} warmer than the left, the upper {gy} than the lower",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Add (gx xi + gy zeta)/2 to the local temperature.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``gx`` and ``gy``, K over the plate's bounding box.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    tilt = 0.5 * (values["gx"] * state.xi + values["gy"] * state.zeta)
    return state.with_(temperature=state.temperature + tilt)


EFFECT = Effect(card, apply)
