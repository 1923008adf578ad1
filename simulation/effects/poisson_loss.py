"""Poisson loss: a polymer dissipates where its shape changes, and hardly where its volume does."""

from collections.abc import Mapping
from typing import Any

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; 1 is a material whose bulk modulus has no loss at all, 0 a real Poisson's ratio."""
    return EffectCard(
        name="poisson_loss",
        summary="changes of shape are lossier than changes of volume, so twisting is lossier than bending",
        parameters=(Parameter("kappa", "1", 0.0, 1.5, 0.5, shown="%"),),
        needs="modes in torsion and in bending along both axes within the band",
        separated_by="the decay of a rod in torsion and in bending; a loss_orthotropy differs along x and y",
        title="loss in shape rather than in volume",
        phrase="a share of {kappa} of the loss in changes of shape alone",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Poisson's ratio nu - j kappa eta (1/2 - nu), to first order in eta; E (1 + j eta) is kept.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``kappa``, the share of the loss of a lossless bulk modulus.

    Returns
    -------
    PlateState
        `state` with the effect.

    Notes
    -----
    With a real bulk modulus K, nu = 1/2 - E/(6 K), so that E (1 + j eta) gives nu - j eta (1/2 - nu) (Pritz, J.
    Sound Vib. 214, 1998). Q11 = E/(1 - nu**2), Q12 = nu Q11 and G = E/(2 (1 + nu)) follow.
    """
    temperature = state.mean_temperature
    nu = state.laws.poisson_ratio(temperature)
    late = values["kappa"] * (0.5 - nu)
    along = late * 2.0 * nu / (1.0 - nu**2)
    return state.with_(
        loss_x=state.loss_x * (1.0 - along),
        loss_y=state.loss_y * (1.0 - along),
        loss_cross=state.loss_cross * (1.0 - along - late / nu),
        loss_shear=state.loss_shear * (1.0 + late / (1.0 + nu)),
    )


EFFECT = Effect(card, apply)
