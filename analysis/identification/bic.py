"""Bayesian information criterion (BIC) of a fit, and its penalty for one pole.

The scale of the noise is taken as unknown (n log misfit): otherwise every small model error would be fitted with
poles.
"""

import numpy as np
from numpy.typing import NDArray

from analysis.identification.lines import Lines
from analysis.identification.pole_search import PoleFit


def bic(fitted: PoleFit, lines: Lines) -> float:
    """Bayesian information criterion, n log(misfit) + parameters log(n); smaller is better."""
    n, misfit = lines.independent, fitted.projection.misfit + lines.hidden
    return float(n * np.log(misfit / lines.values) + fitted.parameters * np.log(n))


def misfit_worth(lines: Lines, level: float, parameters: int) -> float:
    """Return the misfit at which a model reaches a BIC of `level`.

    Parameters
    ----------
    lines : Lines
    level : float
        BIC.
    parameters : int
        Real parameters of the model.

    Returns
    -------
    float
        Sum of squared errors in units of the deviations; negative where no misfit is low enough.
    """
    n = lines.independent
    return float(lines.values * np.exp((level - parameters * np.log(n)) / n) - lines.hidden)


def pole_penalty(lines: Lines) -> float:
    """Return the BIC penalty for one pole: two parameters and a complex residue for every response."""
    return float((2 + 2 * len(lines.h)) * np.log(lines.independent))


def support(fitted: PoleFit, lines: Lines) -> NDArray[np.float64]:
    """Rise of BIC, at most, if each pole were dropped: (J,) ndarray.

    An upper bound, because the other poles are not refitted; a pole with a negative value has to be dropped.
    """
    n, now = lines.independent, fitted.projection
    rise: NDArray[np.float64] = n * np.log1p(now.loss / (now.misfit + lines.hidden)) - pole_penalty(lines)
    return rise
