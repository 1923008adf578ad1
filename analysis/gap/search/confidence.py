"""Probability of a named effect: a softmax over the effect, its rivals, no effect, and an unknown cause."""

from collections.abc import Mapping, Sequence

import numpy as np

from analysis.gap.thresholds import CLASS_COSINE, CLASS_NATS, TEMPERATURE_OF_CONFIDENCE, UNLISTED


def equivalents(rivals: Mapping[str, float], signal_cosines: Mapping[str, float]) -> tuple[str, ...]:
    """Other effects that this campaign cannot distinguish from an effect, nearest first.

    Parameters
    ----------
    rivals : mapping
        Log evidence of each other effect in its place, relative to it, nats.
    signal_cosines : mapping
        Cosine between the effect's signal and the nearest signal of each other effect.
    """
    alike = [
        name for name, gain in rivals.items() if gain > -CLASS_NATS or signal_cosines.get(name, 0.0) > CLASS_COSINE
    ]
    return tuple(sorted(alike, key=lambda name: -rivals[name]))


def against(gain: float, rivals: Mapping[str, float], unknown: float, chi2_per_dof: float) -> dict[str, float]:
    """Log evidence of all alternatives to an effect, relative to it, nats.

    Parameters
    ----------
    gain : float
        Log evidence of the effect over the twin without it.
    rivals : mapping
        Log evidence of others in its place, relative to it.
    unknown : float
        Log evidence of a smooth discrepancy of unknown cause in its place, over the twin without it.
    chi2_per_dof : float
        Of the fit: where more than noise is left, differences of log likelihood are too large by this factor.

    Returns
    -------
    dict of str to float
        By effect, besides ``nothing`` and ``unknown``.
    """
    everything = {"nothing": -gain, "unknown": unknown - gain, **rivals}
    return {name: value / max(chi2_per_dof, 1.0) for name, value in everything.items()}


def probability(
    others: Mapping[str, float],
    alike: Sequence[str],
    temperature: float = TEMPERATURE_OF_CONFIDENCE,
    unlisted: float = UNLISTED,
) -> float:
    """Probability that an effect, or one of its equivalents, is present.

    Parameters
    ----------
    others : mapping
        As from `against`.
    alike : sequence of str
        Its equivalents.
    temperature : float
        Divisor of differences of log evidence.
    unlisted : float
        Probability that a cause outside the library acts like the effect; the data cannot exclude it.

    Returns
    -------
    float
        0 to 1 - `unlisted`.
    """
    mine = [0.0, *(others[name] for name in alike)]
    scaled = np.array(mine + [value for name, value in others.items() if name not in alike]) / temperature
    weight = np.exp(scaled - scaled.max())
    return float((1.0 - unlisted) * weight[: len(mine)].sum() / weight.sum())
