"""Random effects of given size, to be hidden in one campaign."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Complex
from analysis.effect_card import EffectCard, Values
from app.blind_trial.assignments import Assignment
from app.blind_trial.effect_size import EffectSize
from simulation.effects.library import LIBRARY

SIZES = (6.0, 15.0, 30.0)
"""Sizes of single effects, sigma, used in turn; the last is the lower end of a range."""
LARGEST_SIZE_RATIO = 8.0
"""Upper end of that range, as a multiple of its lower end."""
USED_RANGE_SHARE = 0.9
"""Share of an effect's range that is used: an estimate at the end of the range is refused."""
SIZE_FACTOR = 0.7
"""Factor on an effect's size for the next try if it exceeds the certified range."""
SETTLED_SIZE_ERROR = 0.03
"""Relative error of a size at which the search for the amplitude ends."""
SIMILAR_COSINE = 0.8
"""Cosine from which two effects count as similar."""


@dataclass(frozen=True)
class DrawnEffects:
    """Hidden effects of a campaign.

    Attributes
    ----------
    effects : mapping
        Parameters by effect.
    size : dict
        Size of each effect alone, in sigma of noise and the twin's own error.
    cosine : float or None
        Between the signals of two effects.
    imitations : dict
        Cosine between the total hidden signal and the nearest signal of each library effect; empty for a single
        effect, which is in the library itself.
    """

    effects: Mapping[str, Values]
    size: dict[str, float]
    cosine: float | None
    imitations: dict[str, float]


def draw_effects(
    assignment: Assignment, first: Sequence[str], others: Sequence[str], yard: EffectSize, rng: np.random.Generator
) -> DrawnEffects:
    """Draw the effects' parameters and scale them to their size.

    Parameters
    ----------
    assignment : Assignment
    first : sequence of str
        Of `wanted`.
    others : sequence of str
        From which the second of a pair is chosen.
    yard : EffectSize
        Campaign for which the size is computed.
    rng : numpy.random.Generator

    Returns
    -------
    DrawnEffects
        Without effects where `first` is empty.
    """
    if not first:
        return DrawnEffects({}, {}, None, {})
    size = wanted_size(assignment, first[0], rng)
    effects = {first[0]: of_size(yard, first[0], size, rng)}
    cosine = None
    if assignment.kind == "pair":
        alike = bool(assignment.ordinal % 2)
        name, values, cosine = _partner(yard, effects, others, wanted_size(assignment, first[0], rng), alike, rng)
        effects[name] = values
    sizes = {name: yard.left(yard.signal({name: values})) for name, values in effects.items()}
    alone = assignment.kind == "single"
    return DrawnEffects(effects, sizes, cosine, {} if alone else yard.imitations(yard.signal(effects)))


def wanted_size(assignment: Assignment, name: str, rng: np.random.Generator) -> float:
    """Size of an effect; single effects take all `SIZES` in three rounds through the library.

    Parameters
    ----------
    assignment : Assignment
    name : str
        Of an effect of the library, for a single one.
    rng : numpy.random.Generator

    Returns
    -------
    float
        Sigma.
    """
    if assignment.kind == "single":
        turn = (tuple(LIBRARY).index(name) + assignment.ordinal // len(LIBRARY)) % len(SIZES)
        if turn + 1 < len(SIZES):
            return SIZES[turn]
    least = 15.0 if assignment.kind == "pair" else SIZES[-1]
    return float(least * LARGEST_SIZE_RATIO ** rng.random())


def of_size(yard: EffectSize, name: str, size: float, rng: np.random.Generator) -> dict[str, float]:
    """Parameters in a random direction, scaled to the given size or to the largest allowed.

    Parameters
    ----------
    yard : EffectSize
    name : str
        Of the effect.
    size : float
        Sigma.
    rng : numpy.random.Generator

    Returns
    -------
    dict of str to float
        Values in the units of the effect's card.
    """
    card = yard.specimen.cards[name]
    direction, shapes = random_values(card, rng)
    most = min(
        USED_RANGE_SHARE * (p.high if direction[p.name] > 0 else p.low) / direction[p.name]
        for p in card.amplitudes
        if direction[p.name]
    )
    amount = min(0.1, most)
    for _ in range(8):
        signal = answered(yard, {name: _values(direction, shapes, amount)})
        if signal is None:
            amount = most = SIZE_FACTOR * amount
            continue
        seen = yard.size(signal)
        if abs(seen / size - 1.0) < SETTLED_SIZE_ERROR or (seen < size and amount == most):
            break
        amount = min(amount * float(np.clip(size / max(seen, 1e-9), 1e-3, 1e3)), most)
    return _values(direction, shapes, amount)


def answered(yard: EffectSize, effects: Mapping[str, Values]) -> Complex | None:
    """Signal of `effects`; None if they exceed the certified range of the plate's operators."""
    try:
        return yard.signal(effects)
    except ValueError:
        return None


def _values(direction: Values, shapes: Values, amount: float) -> dict[str, float]:
    return {**{p: amount * part for p, part in direction.items()}, **shapes}


def random_values(card: EffectCard, rng: np.random.Generator) -> tuple[dict[str, float], dict[str, float]]:
    """Random amplitudes of about one prior standard deviation, and shapes in the inner part of their ranges."""
    drawn = {p.name: p.sigma * float(rng.standard_normal()) for p in card.amplitudes}
    for p in card.amplitudes:
        if p.low == 0.0 or p.high == 0.0:
            drawn[p.name] = abs(drawn[p.name]) * (1.0 if p.low == 0.0 else -1.0)
    shapes = {
        p.name: float(p.low + rng.uniform(0.15, 0.85) * (p.high - p.low)) for p in card.parameters if p.shape
    }
    return drawn, shapes


def _partner(
    yard: EffectSize,
    first: Mapping[str, Values],
    known: Sequence[str],
    size: float,
    alike: bool,
    rng: np.random.Generator,
) -> tuple[str, dict[str, float], float]:
    """Return the second effect, the most similar or dissimilar of a few draws, its parameters and the cosine."""
    signal = yard.signal(first)
    near = yard.imitations(signal)
    others = [str(name) for name in rng.permutation([name for name in known if name not in first])]
    if alike:
        others.sort(key=lambda name: -near.get(name, 0.0))
    best: tuple[str, dict[str, float], float] | None = None
    for name in others[:4]:
        values = of_size(yard, name, size, rng)
        if answered(yard, {**first, name: values}) is None:
            continue
        cosine = abs(yard.cosine(signal, yard.signal({name: values})))
        if (cosine >= SIMILAR_COSINE) == alike:
            return name, values, cosine
        if best is None or (alike and cosine > best[2]):
            best = (name, values, cosine)
    if best is None:
        raise ValueError("no effect is left to make a pair")
    return best
