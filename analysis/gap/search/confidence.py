"""Probability of a named effect: a softmax over the effect, its rivals, no effect, and an unknown cause.

Unknown cause: evidence that a smooth discrepancy of no known effect explains the residual.

After Kennedy and O'Hagan (J. R. Statist. Soc. B 63, 2001) a twin's discrepancy is a Gaussian process. Here it is
expanded in averages over neighbouring nodes (a fraction of a resonance) and in the lowest cosines over
temperature. Its variance in each frequency band and order is estimated from the residual, so its evidence has a
closed form. A named effect that explains less than this discrepancy is not accepted.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dct

from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.state import GapState
from analysis.gap.thresholds import CLASS_COSINE, CLASS_NATS, NOISE_BELOW, TEMPERATURE_OF_CONFIDENCE, UNLISTED

NO_EFFECT = ("nothing", "unknown")
"""Alternatives to an effect that are no effect of the library, see `against`."""


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
    everything = dict(zip(NO_EFFECT, (-gain, unknown - gain), strict=True)) | dict(rivals)
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


NODES_TOGETHER = 2
"""Number of nodes per average: a third of the width of a resonance."""
ORDERS = 6
"""Number of cosines over temperature."""
BANDS = 12
"""Number of frequency bands with a variance of their own."""
DRAWS = 10_000
"""Number of noise draws for a quantile: that of 0.99 is known to a tenth of a nat."""


def unknown_evidence(sweeps: GapSweeps, residual: NDArray[np.complex128], state: GapState) -> float:
    """Log evidence, over pure noise, of a smooth discrepancy behind a residual.

    Computed at fixed frequencies and at frequencies that shift with E like resonances; the larger value is
    returned.

    Parameters
    ----------
    sweeps : GapSweeps
    residual : (T, K, n) complex ndarray
        Whitened.
    state : GapState
        Its laws give the shift of resonances with temperature.

    Returns
    -------
    float
        Nats.
    """
    fixed = np.zeros(sweeps.count, dtype=int)
    frequency = sweeps.nodes.frequency
    per_node = float(np.median(np.diff(np.log(frequency))))
    stiffness = state.laws[sweeps.groups.of_sweep, 0]
    moving = np.round(0.5 * (stiffness - stiffness.mean()) / per_node).astype(int)
    return max(_evidence(sweeps, residual, shift) for shift in (fixed, moving))


def noise_evidence(sweeps: GapSweeps) -> float:
    """Log evidence of `unknown_evidence` that a share `NOISE_BELOW` of pure noise stays below.

    Drawn from the distribution of the variances v of white noise, with a fixed seed.

    Parameters
    ----------
    sweeps : GapSweeps

    Returns
    -------
    float
        Nats.
    """
    rng = np.random.default_rng(0)
    averages = sweeps.nodes.frequency.size // NODES_TOGETHER
    total = np.zeros((2, DRAWS))  # fixed and moving frequencies, as if independent: an upper bound of the quantile
    for leg in sweeps.legs:
        for band in np.array_split(np.arange(averages), min(BANDS, averages)):
            count = len(sweeps.channels) * band.size
            for _ in range(min(ORDERS, len(leg))):
                total += _free_variance_evidence(rng.gamma(count, 1.0 / count, total.shape), count)
    return float(np.quantile(total.max(0), NOISE_BELOW))


def _evidence(sweeps: GapSweeps, residual: NDArray[np.complex128], shift: NDArray[np.int_]) -> float:
    n = residual.shape[-1]
    aligned = np.zeros_like(residual)
    for s, by in enumerate(shift):
        width = n - abs(int(by))
        if width > 0:
            here, there = max(-int(by), 0), max(int(by), 0)
            aligned[s, :, here : here + width] = residual[s, :, there : there + width]
    usable = n // NODES_TOGETHER * NODES_TOGETHER
    blocks = aligned[..., :usable].reshape(*aligned.shape[:2], -1, NODES_TOGETHER)
    averages = blocks.sum(-1) / np.sqrt(NODES_TOGETHER)
    total = 0.0
    for leg in sweeps.legs:
        ordered = averages[leg]
        orders = dct(ordered.real, axis=0, norm="ortho") + 1j * dct(ordered.imag, axis=0, norm="ortho")
        for order in orders[:ORDERS]:
            for band in np.array_split(order, min(BANDS, order.shape[-1]), axis=-1):
                total += float(_free_variance_evidence((np.abs(band) ** 2).mean() / 2.0, band.size))
    return total


def _free_variance_evidence(variance: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """Log evidence that `count` complex numbers of mean `variance` v of each part have more than noise's 1.

    The best variance gives count (v - 1 - log v), less half of log(count) as its penalty.
    """
    v = np.maximum(variance, 1.0)
    return np.asarray(np.maximum(count * (v - 1.0 - np.log(v)) - 0.5 * np.log(count), 0.0))
