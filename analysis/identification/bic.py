"""Bayesian information criterion (BIC) of a fit, and its penalty for one pole.

The scale of the noise is taken as unknown (n log misfit): otherwise every small model error would be fitted with
poles. Where responses share their errors, as those of the measured force, they count as fewer, in the number of
values and in that of residues.
"""

import numpy as np
from numpy.typing import NDArray

from analysis.identification.lines import Lines
from analysis.identification.pole_search import PoleFit
from analysis.identification.residual_terms import ResidualTerms


def bic(fitted: PoleFit, lines: Lines) -> float:
    """Bayesian information criterion, n log(misfit) + parameters log(n); smaller is better."""
    n, misfit = lines.independent, fitted.projection.misfit + lines.hidden
    parameters = _parameters(lines, len(fitted.poles), fitted.terms)
    return float(n * np.log(misfit / lines.values) + parameters * np.log(n))


def _parameters(lines: Lines, poles: int, terms: ResidualTerms) -> float:
    """Two of every pole; two of every residue, and the residual terms, for every independent response."""
    return 2 * poles + (2 * poles + terms.parameters) * lines.responses


def misfit_worth(lines: Lines, level: float, poles: int, terms: ResidualTerms) -> float:
    """Return the misfit at which a model reaches a BIC of `level`.

    Parameters
    ----------
    level : float
        BIC.
    poles : int
        Number of poles of the model.
    terms : ResidualTerms
        Of the model.

    Returns
    -------
    float
        Sum of squared errors in units of the deviations; negative where no misfit is low enough.
    """
    n = lines.independent
    penalty = _parameters(lines, poles, terms) * np.log(n)
    return float(lines.values * np.exp((level - penalty) / n) - lines.hidden)


def pole_penalty(lines: Lines) -> float:
    """Return the BIC penalty for one pole: two parameters, and a complex residue for every response."""
    return float((2.0 + 2.0 * lines.responses) * np.log(lines.independent))


def support(fitted: PoleFit, lines: Lines) -> NDArray[np.float64]:
    """Rise of BIC, at most, if each pole were dropped: (J,) ndarray.

    An upper bound, because the other poles are not refitted; a pole with a negative value has to be dropped.
    """
    n, now = lines.independent, fitted.projection
    rise: NDArray[np.float64] = n * np.log1p(now.loss / (now.misfit + lines.hidden)) - pole_penalty(lines)
    return rise
