"""Thickness crown: the plate is thicker in the middle than at its edges, as rolled or pressed sheets are."""

from collections.abc import Mapping
from typing import Any

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; 2 % is what cubic fields hold h**3 to 5e-4 of a response for."""
    return EffectCard(
        name="thickness_crown",
        summary="the plate is thicker or thinner in the middle than at its edges",
        parameters=(
            Parameter("cx", "1", -0.02, 0.02, 0.005, shown="%"),
            Parameter("cy", "1", -0.02, 0.02, 0.005, shown="%"),
        ),
        needs="modes of several half-waves along both axes",
        separated_by="a thickness gauge in the middle and at the edges; a thermal_crown goes with the heating",
        title="thickness that differs between middle and edges",
        phrase="a thickness in the middle that differs by {cx} along x and {cy} along y",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Thickness times 1 + cx (1/3 - xi**2) + cy (1/3 - zeta**2); the mean is kept.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``cx`` and ``cy``, thicker in the middle than at the edges along x and y, relative.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    crown = values["cx"] * (1.0 / 3.0 - state.xi**2) + values["cy"] * (1.0 / 3.0 - state.zeta**2)
    return state.with_(thickness=state.thickness * (1.0 + crown))


EFFECT = Effect(card, apply)
