"""Patch loss: ceramic and glue of the patches dissipate, too."""

from collections.abc import Mapping
from typing import Any

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; soft ceramics lose one to three hundredths, with the glue's share up to a tenth."""
    return EffectCard(
        name="patch_loss",
        summary="ceramic and glue of the patches have a loss factor of their own",
        parameters=(Parameter("eta", "1", 0.0, 0.5, 0.05, shown="%"),),
        needs="modes that strain the patches and others that do not",
        separated_by=(
            "the decay of a beam with a patch and without; the patches' electrical impedance at resonance"
        ),
        title="loss of the patches",
        phrase="a loss factor of {eta} of the patches and their glue",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Loss factor of the membrane stiffness of all patches, which is nearly all of it.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``eta``.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    return state.with_(patch_loss=state.patch_loss + values["eta"])


def available(experiment: Experiment) -> bool:
    """Return whether there is a patch."""
    return bool(experiment.patch)


EFFECT = Effect(card, apply, available, "a patch")
