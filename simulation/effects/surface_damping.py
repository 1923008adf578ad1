"""Surface damping: friction in cloth, foam or narrow gaps beside the plate, in proportion to its velocity."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; one prior sigma is a loss factor of 0.01 in the middle of the band."""
    plate, middle = experiment.plate, float(np.sqrt(np.prod(experiment.protocol.band)))
    usual = 0.01 * plate.mass / plate.area * 2.0 * np.pi * middle
    return EffectCard(
        name="surface_damping",
        summary="friction in foam or cloth all over the plate brakes its velocity",
        parameters=(Parameter("resistance", "N s/m3", 0.0, 50.0 * usual, usual, shown="N s/m³"),),
        needs=("modes over at least two octaves, better with a loss factor that changes over temperature"),
        separated_by=(
            "a sweep without what touches the plate; an exponential window of a hammer test acts alike, a "
            "damping_dispersion with p = -1 nearly so"
        ),
        title="friction on the faces",
        phrase="a friction of {resistance} all over the plate",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Add the resistance per area to normal motion.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``resistance``, N s/m3.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    return state.with_(area_resistance=state.area_resistance + values["resistance"])


EFFECT = Effect(card, apply)
