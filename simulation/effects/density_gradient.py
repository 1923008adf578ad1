"""Density gradient: the plate is heavier at one side than at the other, and no stiffer."""

from collections.abc import Mapping
from typing import Any

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; foil, paint or filler on one side make some per cent."""
    return EffectCard(
        name="density_gradient",
        summary="the plate is heavier at one side than at the other, but not stiffer",
        parameters=(
            Parameter("mx", "1", -0.09, 0.09, 0.02, shown="%"),
            Parameter("my", "1", -0.09, 0.09, 0.02, shown="%"),
        ),
        needs="modes of several half-waves along both axes",
        separated_by=(
            "weigh the plate on two edges, or strips cut from both sides; a thickness_taper is stiffer, too"
        ),
        title="plate heavier at one side",
        phrase="a density that changes by {mx} along x and {my} along y",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Mass per area times 1 + mx xi + my zeta; the mean is kept.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``mx`` and ``my``, relative, at the right and upper side.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    return state.with_(density=state.density * (1.0 + values["mx"] * state.xi + values["my"] * state.zeta))


EFFECT = Effect(card, apply)
