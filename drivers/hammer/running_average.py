"""Coherence of the hits at one point, as they come."""

import numpy as np

from analysis.estimation.estimators import estimate
from analysis.estimation.spectra import Spectra, pooled


def coherence_so_far(hits: list[Spectra], band: tuple[float, float]) -> float | None:
    """Return the mean coherence over a band, of the response where it is least; None of fewer than two hits.

    Parameters
    ----------
    band : (float, float)
        Hz.
    """
    if len(hits) < 2:
        return None
    found = estimate(pooled(hits))
    inside = (found.frequency >= band[0]) & (found.frequency <= band[1])
    return float(np.min(found.coherence[:, inside].mean(axis=1)))
