"""Amplitude softening: the modulus falls and the loss rises with strain amplitude."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState

LARGEST_STRAIN_ENERGY = 4.0  # largest relative strain energy: strongest resonance at twice the level


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; at the largest strain energy both moduli stay positive within these ranges."""
    return EffectCard(
        name="amplitude_softening",
        summary="the plate is softer and lossier at its resonances, the more the harder it is driven",
        parameters=(Parameter("a", "1", 0.0, 0.2, 0.05, shown="%"), Parameter("b", "1", 0.0, 0.5, 0.1, shown="%")),
        needs="two drive levels at the same temperatures",
        levels=2,
        separated_by="sweeps at half and at twice the level: what changes is the amplitude's doing",
        title="softening with amplitude",
        phrase="per unit of relative strain energy the plate gets softer by {a} and lossier by {b}",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Storage modulus times 1 - a e, loss modulus times 1 - a e + b e, e the relative strain energy, at most 4.

    The energy is that of the softened plate, found by iteration in `simulation.twin.strain_energy`.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``a`` and ``b``, per unit of relative strain energy.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    energy = np.minimum(circumstances.strain_energy, LARGEST_STRAIN_ENERGY)
    kept = 1.0 - values["a"] * energy
    return state.with_(storage=state.storage * kept, loss=state.loss * (kept + values["b"] * energy))


EFFECT = Effect(card, apply, needs_strain_energy=True)
