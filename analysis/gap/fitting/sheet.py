"""Constants of an orthotropic sheet by direction from a fit: laws and ratios with their covariance."""

import numpy as np

from analysis.arrays import Real
from analysis.declaration.plate_material import Orthotropy
from analysis.gap.fitting.gap_fit import GapFit
from analysis.sheet_material import RATIOS, SheetMaterial


def fitted_sheet(
    declared: Orthotropy | None, fit: GapFit, sigma: Real | None = None, own: Real | None = None
) -> SheetMaterial | None:
    """Return the constants at a fit's groups.

    Parameters
    ----------
    declared : Orthotropy or None
        None for an isotropic sheet, which has none.
    fit : GapFit
    sigma : (G, 3) ndarray, optional
        Total standard deviations of log E, nu and log eta; those of the fit by default.
    own : (G, 3) ndarray, optional
        Part of their variances by each sweep's noise; that of the fit by default.

    Returns
    -------
    SheetMaterial or None
    """
    if declared is None:
        return None
    free, stated, laws = fit.free, fit.stated, fit.state.laws
    chosen = [free.names.index(pair) if pair in free.names else None for pair in RATIOS]
    covariance = stated.beside(chosen)
    if sigma is not None:
        place = np.arange(3)
        covariance[:, place, place] = np.maximum(covariance[:, place, place], sigma**2)
    if own is None:
        own = np.maximum(fit.noise.laws**2 - (fit.noise.common**2).sum(axis=2), 0.0)
    moved = np.zeros((len(laws), 3 + len(RATIOS), len(free.names)))
    moved[:, :3] = stated.common
    for row, k in enumerate(chosen, start=3):
        if k is not None:
            moved[:, row] = stated.own[k] / free.sigma
    values = fit.state.on
    ratios = np.array([values.get(name, {}).get(parameter, 0.0) for name, parameter in RATIOS])
    return SheetMaterial.of(declared, laws, ratios, covariance, moved[:, :, free.effects :], own)
