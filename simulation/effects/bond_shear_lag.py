"""Bond shear lag: a compliant glue line transmits only a part of the patches' strain, less when warm."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState

REFERENCE_TEMPERATURE = 25.0  # degrees Celsius, at which gamma25 is given


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; epoxies keep softening below 0.03 per kelvin until their glass transition."""
    return EffectCard(
        name="bond_shear_lag",
        summary="the glue under the patches shears, and softens with temperature",
        parameters=(
            Parameter("gamma25", "1", 0.0, 1.0, 0.1),
            Parameter("softening", "1/K", 0.0, 0.1, 0.03, shape=True, typical=0.03, shown="%/K"),
        ),
        needs="a wide temperature range with one gain for all of it, and modes that the patches stiffen",
        separated_by="the patches' electrical impedance over temperature: a soft bond flattens its resonances",
        sites=({"softening": 0.0}, {"softening": 0.03}, {"softening": 0.06}),
        title="soft glue under the patches",
        phrase="the glue under the patches gives way: shear lag {gamma25} at 25 °C, growing by {softening}",
    )


def available(experiment: Experiment) -> bool:
    """Return whether there is a patch."""
    return bool(experiment.patch)


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Multiply membrane stiffness and coupling of every patch by chi = 1/(1 + gamma25 exp(softening (T - 25))).

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``gamma25``, the shear lag at 25 °C, and ``softening``, 1/K.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    warmer = state.mean_temperature - REFERENCE_TEMPERATURE
    chi = 1.0 / (1.0 + values["gamma25"] * np.exp(values["softening"] * warmer))
    return state.with_(bond=state.bond * chi)


EFFECT = Effect(card, apply, available, "a patch")
