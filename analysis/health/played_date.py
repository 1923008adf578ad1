"""A date from sound: what the panel answered while it played, recorded beside the drives.

Where the drives are independent of each other, H1 of several drives gives the response to each. A panel whose
filters play one piece of sound has drives that are filtered from one signal: then the responses r_k to the drive
of input q, at which the others are u_i = G_iq / G_qq, are compared with sum_i u_i H_ik.
"""

import numpy as np

from analysis.arrays import Complex, Mask, Real
from analysis.estimation.estimators import FrfEstimate, estimate
from analysis.estimation.recording import SampledSignals
from analysis.estimation.spectra import Spectra, welch
from analysis.gap.data.compression import Nodes, compress
from analysis.health.recording import DatedRecording

LINES_IN_HALF_WIDTH = 20.0
"""Lines of a segment in half the width of the sharpest resonance: a Hann window then lowers its peak by
1 / (3 20²), less than a part in a thousand."""
FEWEST_AVERAGES = 16.0
"""Independent segments: with fewer the variance that the coherence gives is itself uncertain by a quarter."""
INDEPENDENT = 0.03
"""Smallest over largest eigenvalue of the drives' coherence from which they are separated: the noise of the
responses is then magnified by six at most."""
ONE_SIGNAL = 0.999
"""Share of the drives' power in one signal, from which they are taken for filtered from it."""


def played_date(
    drives: Real,
    responses: Real,
    rate: float,
    lines: Real,
    excluded: Mask,
    nodes: Nodes,
    half_width: float,
    date: str,
) -> DatedRecording:
    """Estimate what a recording of sound says of a panel, at the lines of its baseline.

    Parameters
    ----------
    drives : (I, n) ndarray
        Of each input, in the units of the baseline.
    responses : (K, n) ndarray
        Of each output, in the units of the baseline.
    rate : float
        Hz.
    lines : (F,) ndarray
        Of the baseline, Hz, evenly spaced.
    excluded : (F,) bool ndarray
        Lines that the baseline leaves out.
    nodes : Nodes
        Of the baseline.
    half_width : float
        Half the width at half power of the sharpest resonance, Hz.
    date : str

    Raises
    ------
    ValueError
        For a recording that is too short, a silent drive, and drives that are neither independent nor one signal.
    """
    spacing = float(np.median(np.diff(lines)))
    times = max(1, int(np.ceil(LINES_IN_HALF_WIDTH * spacing / half_width)))
    segment = times / spacing
    if drives.shape[1] < segment * rate:
        raise ValueError(f"{drives.shape[1] / rate:.0f} s of sound; segments of {segment:.0f} s are needed")
    whole = welch(SampledSignals(rate, drives, responses), segment)
    place = np.searchsorted(whole.frequency, lines - 0.25 * spacing / times)
    if place[-1] >= len(whole.frequency) or whole.averages < FEWEST_AVERAGES:
        needed = FEWEST_AVERAGES / whole.averages * drives.shape[1] / rate
        raise ValueError(
            f"{drives.shape[1] / rate:.0f} s of sound up to {whole.frequency[-1]:.0f} Hz; needed: {needed:.0f} s "
            f"or more, and the band of the baseline, up to {lines[-1]:.0f} Hz"
        )
    at = place[~excluded]
    first, last = max(int(at[0]), 1), int(at[-1]) + 1
    spectra = Spectra(
        whole.frequency[first - 1 : last],
        whole.g_uu[first - 1 : last],
        whole.g_yu[first - 1 : last],
        whole.g_yy[first - 1 : last],
        whole.averages,
    )
    at = at - first  # an estimate has no line at the first frequency of its spectra
    _require_heard(spectra)
    smallest, largest = _eigenvalues(spectra)
    if len(drives) == 1 or float(np.quantile(smallest[at], 0.05)) > INDEPENDENT:
        found = estimate(spectra)
        sweeps = tuple(
            compress(found.h[:, n][:, at], _variance(found)[:, n][:, at], nodes) for n in range(len(drives))
        )
        return DatedRecording(date, None, sweeps)
    if float(np.quantile(largest[at], 0.05)) < ONE_SIGNAL:
        raise ValueError(
            "its drives are partly one signal; allowed: drives that are independent of each other, or all "
            "filtered from one signal, as flexura render writes them"
        )
    power = np.einsum("fii->i", spectra.g_uu[at + 1]).real
    loudest = int(power.argmax())
    found = estimate(_from_one(spectra, loudest))
    count = len(responses)
    u = np.ones((len(drives), len(at)), dtype=complex)
    others = [n for n in range(len(drives)) if n != loudest]
    u[others] = found.h[count:, 0][:, at]
    mix = nodes.at_nodes(compress(u, np.ones(u.shape), nodes).coefficients)
    sweep = compress(found.h[:count, 0][:, at], _variance(found)[:count, 0][:, at], nodes)
    return DatedRecording(date, None, (sweep,), mix[None])


def _require_heard(spectra: Spectra) -> None:
    power = np.einsum("fii->fi", spectra.g_uu).real[1:]
    silent = np.flatnonzero(~(power > 0.0).all(axis=0))
    if silent.size or not (spectra.g_yy[1:] > 0.0).all():
        raise ValueError("a drive or a response is silent in the band; every input must drive")


def _eigenvalues(spectra: Spectra) -> tuple[Real, Real]:
    """Eigenvalues of the drives' coherence: smallest over largest, and largest over the sum, (F - 1,) each."""
    g = spectra.g_uu[1:]
    scale = np.sqrt(np.einsum("fii->fi", g).real)
    values = np.linalg.eigvalsh(g / (scale[:, :, None] * scale[:, None, :]))
    return values[:, 0] / values[:, -1], values[:, -1] / values.sum(axis=1)


def _from_one(spectra: Spectra, which: int) -> Spectra:
    """Spectra of all responses, and the other drives behind them, by one drive."""
    others = [n for n in range(spectra.g_uu.shape[1]) if n != which]
    by: Complex = np.concatenate([spectra.g_yu[:, :, [which]], spectra.g_uu[:, others][:, :, [which]]], axis=1)
    own = np.einsum("fii->fi", spectra.g_uu).real[:, others]
    return Spectra(
        spectra.frequency,
        spectra.g_uu[:, [which]][:, :, [which]],
        by,
        np.concatenate([spectra.g_yy, own], axis=1),
        spectra.averages,
    )


def _variance(found: FrfEstimate) -> Real:
    """Variance (K, M, F), no smaller than rounding leaves."""
    if found.variance is None:
        raise ValueError("as many segments as drives; record longer")
    floor = 1e-12 * np.mean(np.abs(found.h) ** 2, axis=-1, keepdims=True)
    return np.asarray(np.maximum(found.variance, floor), dtype=np.float64)
