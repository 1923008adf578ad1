"""How sure a name is: a softmax over the effect, its rivals, nothing, and the unknown."""

from collections.abc import Mapping, Sequence

import numpy as np

from analysis.gap.thresholds import CLASS_COSINE, CLASS_NATS, TEMPERATURE_OF_CONFIDENCE


def equivalents(rivals: Mapping[str, float], mimicry: Mapping[str, float]) -> tuple[str, ...]:
    """Rivals that this campaign cannot tell from an effect, nearest first.

    Parameters
    ----------
    rivals : mapping
        Log evidence of each other effect in its place, relative to it, nats.
    mimicry : mapping
        Cosine between the effect's signal and the nearest that each other can make.
    """
    alike = [name for name, gain in rivals.items() if gain > -CLASS_NATS or mimicry.get(name, 0.0) > CLASS_COSINE]
    return tuple(sorted(alike, key=lambda name: -rivals[name]))


def probability(
    gain: float, rivals: Mapping[str, float], alike: Sequence[str], unknown: float, chi2_per_dof: float
) -> float:
    """Probability that an effect, or one of its equivalents, is present.

    Parameters
    ----------
    gain : float
        Log evidence of the effect over the twin without it, nats.
    rivals : mapping
        Log evidence of others in its place, relative to it.
    alike : sequence of str
        Its equivalents.
    unknown : float
        Log evidence of a nameless smooth discrepancy in its place, over the twin without it.
    chi2_per_dof : float
        Of the fit: where more than noise is left, the likelihood overstates every difference by as much.
    """
    temperature = TEMPERATURE_OF_CONFIDENCE * max(chi2_per_dof, 1.0)
    mine = [0.0, *(rivals[name] for name in alike)]
    others = [-gain, unknown - gain, *(value for name, value in rivals.items() if name not in alike)]
    scaled = np.array(mine + others) / temperature
    weight = np.exp(scaled - scaled.max())
    return float(weight[: len(mine)].sum() / weight.sum())
