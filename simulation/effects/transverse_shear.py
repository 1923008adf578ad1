"""Transverse shear: the plate is softer or stiffer in shear across its thickness than its E and nu say."""

from collections.abc import Mapping
from typing import Any

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect, isotropic
from simulation.state.plate_state import Circumstances, PlateState


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; a foamed core or plies make it softer by a third and more."""
    return EffectCard(
        name="transverse_shear",
        summary="the plate shears more or less through its thickness than an isotropic one",
        parameters=(Parameter("delta", "1", -0.4, 0.4, 0.15, shown="%"),),
        needs=(
            "modes with half-waves of some ten thicknesses; with longer ones the tolerances plate_shear and "
            "plate_theory absorb it"
        ),
        separated_by=(
            "the thickness, measured: declared some per cent too large it looks like a larger shear modulus; then "
            "a short beam in three-point bending, which shears more than a long one"
        ),
        title="shear through the thickness",
        replaces="plate_shear",
        phrase="a transverse shear modulus changed by {delta}",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Transverse shear modulus times 1 + delta.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``delta``.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    return state.with_(transverse_shear=state.transverse_shear * (1.0 + values["delta"]))


EFFECT = Effect(card, apply, isotropic, nothing_missing=True)
