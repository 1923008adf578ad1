"""Orthotropy: different moduli along x and y, from a flow or rolling direction."""

from collections.abc import Mapping
from typing import Any

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect, isotropic
from simulation.state.plate_state import Circumstances, PlateState


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate."""
    return EffectCard(
        name="orthotropy",
        summary="the plate is stiffer along one edge than along the other",
        parameters=(
            Parameter("delta_e", "1", -0.12, 0.12, 0.05, shown="%"),
            Parameter("delta_g", "1", -0.12, 0.12, 0.05, shown="%"),
        ),
        needs="modes along x, along y and in torsion within the band",
        separated_by="cut strips along x and y and measure their moduli",
        title="stiffness that differs along x and y",
        phrase="stiffer along y by {delta_e}, along x softer by as much; stiffer in shear by {delta_g}",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """E_x = E (1 - delta_e), E_y = E (1 + delta_e), in-plane shear modulus times 1 + delta_g.

    nu_xy nu_yx = nu**2, so Q12 is proportional to the root of E_x E_y; transverse shear is not changed.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``delta_e`` and ``delta_g``, shares of the moduli.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    return state.with_(
        modulus_x=state.modulus_x * (1.0 - values["delta_e"]),
        modulus_y=state.modulus_y * (1.0 + values["delta_e"]),
        in_plane_shear=state.in_plane_shear * (1.0 + values["delta_g"]),
    )


EFFECT = Effect(card, apply, isotropic, nothing_missing=True)
