"""Small causes in every campaign of a trial that nobody tells and the judging library lacks.

They are what a laboratory has besides the one effect that is looked for: loss that differs by direction or
frequency, a foam below the plate, air, strings that resonate. Together they make the resonances scatter about
those of the twin by a given amount.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from analysis.effect_card import EffectCard, Values
from app.blind_trial.draw_effects import USED_RANGE_SHARE, random_values
from app.blind_trial.effect_size import EffectSize

NUISANCES = (
    "loss_orthotropy",
    "damping_dispersion",
    "suspension",
    "elastic_foundation",
    "surface_damping",
    "air_loading",
    "resonator_at_place",
)
"""Effects of the library; those drawn are taken from it when the campaign is judged."""
NUISANCE_SCATTER = (0.0, 0.001, 0.003, 0.01)
"""Scatter of the resonances that they make, used in turn: relative, frequency and half loss factor together."""
CAUSES_AT_ONCE = 3
"""Different causes that are mixed in one campaign."""
REFUSED_FACTOR = 0.5
"""Factor on all of them while the twin refuses them."""
MOST_SCALINGS, SCATTER_ERROR = 6, 0.1
"""Largest number of times that they are scaled, and how near the scatter comes."""


@dataclass(frozen=True)
class Nuisances:
    """Small causes of one campaign.

    Attributes
    ----------
    effects : mapping
        Parameters by effect.
    scatter : float
        That they make.
    """

    effects: Mapping[str, Values] = field(default_factory=dict)
    scatter: float = 0.0


def draw_nuisances(
    wanted: float, left_out: Sequence[str], yard: EffectSize, rng: np.random.Generator
) -> Nuisances:
    """Draw a few causes and scale them to a scatter of the resonances.

    Parameters
    ----------
    wanted : float
        One of `NUISANCE_SCATTER`.
    left_out : sequence of str
        Effects that are hidden.
    yard : EffectSize
        Campaign for which the scatter is computed.
    rng : numpy.random.Generator

    Returns
    -------
    Nuisances
    """
    cards = yard.specimen.cards
    names = [name for name in NUISANCES if name in cards and name not in left_out]
    chosen = [str(name) for name in rng.permutation(names)[:CAUSES_AT_ONCE]]
    drawn = {name: random_values(cards[name], rng) for name in chosen}
    if not wanted:
        return Nuisances()
    amount, found = 0.1, Nuisances()
    for _ in range(MOST_SCALINGS):
        effects = {name: _scaled(cards[name], *drawn[name], amount) for name in chosen}
        scatter = yard.scatter(effects)
        if scatter is None:
            amount *= REFUSED_FACTOR
            continue
        found = Nuisances(effects, scatter)
        if abs(scatter / wanted - 1.0) < SCATTER_ERROR:
            break
        amount *= float(np.clip(wanted / scatter, 0.1, 10.0))
    return found


def _scaled(card: EffectCard, amplitudes: Values, shapes: Values, amount: float) -> dict[str, float]:
    within = {
        p.name: float(np.clip(amount * amplitudes[p.name], USED_RANGE_SHARE * p.low, USED_RANGE_SHARE * p.high))
        for p in card.amplitudes
    }
    return {**within, **shapes}
