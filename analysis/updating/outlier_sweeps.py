"""Outlier sweeps: the twin explains their neighbours but not them (clipping, a knock, swapped files)."""

import numpy as np

from analysis.frf import Frf
from analysis.updated import Updated

NEAR = 6.0
"""Largest temperature difference of neighbours, K: a model error shows in all sweeps within it."""
LEAST_NEIGHBOURS = 2
FAR_WORSE = 10.0
"""Ratio of chi2 to that of every neighbour from which a sweep is an outlier: effects vary smoothly."""


def outlier_sweeps(frf: Frf, updated: Updated) -> list[int]:
    """Return the sweeps whose misfit, with a material of their own, far exceeds that of all their neighbours.

    Neighbours are sweeps of one input at one level within `NEAR`; a sweep with fewer than two is not judged.
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
