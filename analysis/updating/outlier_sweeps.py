"""Sweeps that no plate explains, though it explains their neighbours: clipped, knocked, mixed up."""

import numpy as np

from analysis.frf import Frf
from analysis.updated import Updated

NEAR = 6.0
"""Sweeps within so many kelvins meet about the same plate, and what a twin lacks shows in all of them."""
LEAST_NEIGHBOURS = 2
FAR_WORSE = 10.0
"""A chi2 so many times that of every neighbour is no physical effect: those follow the temperature."""


def outlier_sweeps(frf: Frf, updated: Updated) -> list[int]:
    """Return the sweeps that the twin, with a material of their own, misses far worse than all their neighbours.

    Neighbours are sweeps of one input at one level within `NEAR`; with fewer than two nothing can be said.
    """
    chi2 = np.maximum(updated.chi2_per_dof, 1.0)
    outliers = []
    for sweep in range(len(chi2)):
        near = (np.abs(frf.temperature - frf.temperature[sweep]) <= NEAR) & (frf.level == frf.level[sweep])
        near &= frf.driven_by == frf.driven_by[sweep]
        near[sweep] = False
        if near.sum() >= LEAST_NEIGHBOURS and chi2[sweep] > FAR_WORSE * chi2[near].max():
            outliers.append(sweep)
    return outliers
