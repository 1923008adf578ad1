"""Loss orthotropy: the plate is lossier along one edge than along the other, as wood and fibre composites are."""

from collections.abc import Mapping
from typing import Any

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect, isotropic
from simulation.state.plate_state import Circumstances, PlateState


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; wood loses two to four times as much across the grain."""
    return EffectCard(
        name="loss_orthotropy",
        summary="the loss factor differs along x, along y and in shear",
        parameters=(
            Parameter("delta_eta", "1", -0.9, 0.9, 0.15, shown="%"),
            Parameter("delta_shear", "1", -0.9, 3.0, 0.15, shown="%"),
        ),
        needs="modes along x, along y and in torsion within the band",
        separated_by="strips cut along x and y, their decay measured; a poisson_loss is alike along x and y",
        title="loss that differs by direction",
        phrase="a loss factor that differs by {delta_eta} along x and y, and by {delta_shear} in shear",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Loss factor times 1 - delta_eta along x, 1 + delta_eta along y and 1 + delta_shear in shear.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``delta_eta`` and ``delta_shear``.

    Returns
    -------
    PlateState
        `state` with the effect.

    Notes
    -----
    Complex moduli along both axes and in shear (McIntyre and Woodhouse, Acta Metall. 36, 1988); the loss factor of
    Q12 is kept at their mean.
    """
    return state.with_(
        loss_x=state.loss_x * (1.0 - values["delta_eta"]),
        loss_y=state.loss_y * (1.0 + values["delta_eta"]),
        loss_shear=state.loss_shear * (1.0 + values["delta_shear"]),
    )


EFFECT = Effect(card, apply, isotropic, nothing_missing=True)
