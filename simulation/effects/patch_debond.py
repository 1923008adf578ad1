"""Patch debond: a part of a patch has come off the plate and neither stiffens it nor acts on it."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState

MOST_PATCHES = 6
"""Of each of which a share is fitted: of more, few sensors do not tell them apart."""


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; one share for each patch, up to those that were certified."""
    names = [patch.id for patch in experiment.patch] or ["A1"]
    return EffectCard(
        name="patch_debond",
        summary="a part of a patch has come off the plate",
        parameters=tuple(Parameter(name, "1", 0.0, 0.4, 0.1, shown="%") for name in names),
        needs=(
            "modes that the patches stiffen, better with several sensors: with one, gain and d31 absorb the "
            "lost coupling"
        ),
        separated_by=(
            "tap the patch, or its electrical impedance; a bond_shear_lag is alike for all patches and goes "
            "with temperature"
        ),
        title="patch that has partly come off",
        phrase="patches that have come off: " + ", ".join(f"{name} by {{{name}}}" for name in names),
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Stiffness and coupling of each patch times 1 - its share; its mass stays.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        Share of each patch that has come off, by its name.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    off = np.array([values[name] for name in circumstances.patches])
    held = (1.0 - state.debonded) * (1.0 - off)
    return state.with_(debonded=1.0 - held)


def available(experiment: Experiment) -> bool:
    """Return whether there are patches, and few of them."""
    return 0 < len(experiment.patch) <= MOST_PATCHES


EFFECT = Effect(card, apply, available, f"one to {MOST_PATCHES} patches")
