"""Thickness taper: the plate is thicker at one end than at the other."""

from collections.abc import Mapping
from typing import Any

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; sheets vary by a few per cent, and the thickness stays positive in these ranges."""
    return EffectCard(
        name="thickness_taper",
        summary="the plate is thicker at one end than at the other",
        parameters=(
            Parameter("tx", "1", -0.05, 0.05, 0.02, shown="%"),
            Parameter("ty", "1", -0.05, 0.05, 0.02, shown="%"),
        ),
        needs="several modes whose motion is larger on one side of the plate, or several sensors",
        separated_by="a thickness gauge along both edges; thermocouples at the corners rule out a draught",
        title="plate of uneven thickness",
        phrase="the thickness grows by {tx} from the middle to the right edge, and by {ty} to the upper edge",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Thickness h0 (1 + tx xi + ty zeta), symmetric about the mid-plane, with the total mass kept.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``tx`` and ``ty``, shares of the thickness.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    share = values["tx"] * state.xi + values["ty"] * state.zeta
    return state.with_(thickness=state.thickness * (1.0 + share))


EFFECT = Effect(card, apply)
