"""The baseline tested against itself: each temperature is left out and predicted from the others.

What a recording of the healthy panel says about a candidate's amplitude, beyond its noise, is the error that the
baseline makes: laws and discrepancy between temperatures, and the baseline's own noise. It is alike on all dates
at one temperature, and does not average out over weeks; its variance is added to that of every estimate.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from analysis.arrays import Real
from analysis.checked_fields import check_finite, check_range, check_shapes
from analysis.health.baseline import HealthBaseline, PanelLinearisation
from analysis.health.recording import DateEquations, date_equations


@dataclass(frozen=True)
class SelfCheck:
    """What a baseline cannot tell about its own panel.

    Attributes
    ----------
    variance : (C,) ndarray
        Of the amplitude of every candidate, in its unit squared.
    misfit, usual : float
        Largest chi2 per degree of freedom of a temperature that was predicted from the others, and their mean.
    """

    variance: Real = field(repr=False)
    misfit: float
    usual: float

    def __post_init__(self) -> None:
        check_shapes(self, variance="C")
        check_finite(self, "variance", "misfit", "usual")
        check_range(self, 0.0, np.inf, "variance", "misfit", "usual")


def self_check(baseline: HealthBaseline, twins: Sequence[PanelLinearisation]) -> SelfCheck:
    """Leave out each temperature of a baseline in turn, but for the first and the last: nothing is extrapolated.

    Parameters
    ----------
    twins : (B,) sequence of PanelLinearisation
        At the temperatures of the baseline, with all candidates.
    """
    said = [
        date_equations(baseline.recordings[index], baseline.without(index).completed(twins[index]))
        for index in baseline.inner
    ]
    return checked(said, [one.family for one in baseline.candidates])


def checked(said: Sequence[DateEquations], families: Sequence[str]) -> SelfCheck:
    """Return what equations of a healthy panel leave open.

    The excess of z squared over one is the error in units of the noise. Single candidates have as few samples as
    the baseline has temperatures: the largest of their own mean, that of their family and that of all is taken.

    Parameters
    ----------
    said : (B,) sequence of DateEquations
    families : (C,) sequence of str
        Of the candidates.
    """
    information = np.array([np.diag(one.matrix) for one in said])
    seen = information > 0.0
    safe = np.where(seen, information, 1.0)
    squares = np.where(seen, np.array([one.gradient for one in said]) ** 2 / safe, 0.0)
    own = squares.mean(axis=0) - 1.0
    names = np.array(families)
    pooled = np.zeros_like(own)
    for name in np.unique(names):
        pooled[names == name] = own[names == name].mean()
    excess = np.maximum(np.maximum(own, pooled), max(float(own.mean()), 0.0)) if own.size else own
    variance = np.maximum(excess, 0.0) * np.where(seen, 1.0 / safe, 0.0).mean(axis=0)
    misfits = [one.chi2 / one.dof for one in said]
    return SelfCheck(variance, max(misfits), float(np.mean(misfits)))
