"""Weeks added up, and the limit that holds the rate of false alarms.

An amplitude c that came on one of the last m dates and stayed is estimated by the m dates together, c = sum J'r
/ sum J'J, with variance 1 / sum J'J + v, v being what the baseline cannot tell, common to all dates. z = c /
sigma is normal on a healthy panel. An alarm is the largest z, over candidates and over m, beyond a limit at
which all of them together exceed it at the stated rate (Bonferroni's bound: it holds however they are
correlated).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.stats import norm

from analysis.arrays import Mask, Real
from analysis.checked_fields import check_shapes
from analysis.health.recording import DateEquations

SPANS = (1, 2, 4, 8, 16)
"""Numbers of last dates that are added up: a change that began between two of them loses a third of its z at most.
Beyond sixteen the baseline's own error dominates."""
LEAST_SEEN = 1e-4
"""Square of the standard deviations that a usual amplitude moves the data, below which it is not seen:
rounding."""
MISFIT_MARGIN = 2.0
"""Over the largest misfit of the self-check, whose temperatures are few and not the ends of the range: there
healthy dates of a simulated panel had 1.4 times as much."""
SHARE_OF_UNKNOWN = 0.5
"""Share of the rate that the test for changes no candidate explains may use."""


@dataclass(frozen=True)
class SpanEstimate:
    """Amplitudes of all candidates by the last dates together.

    Attributes
    ----------
    span : int
        Number of dates.
    amplitude, sigma : (C,) ndarray
        In the candidates' units; infinite sigma where nothing is seen.
    """

    span: int
    amplitude: Real = field(repr=False)
    sigma: Real = field(repr=False)

    def __post_init__(self) -> None:
        check_shapes(self, amplitude="C", sigma="C")
        if self.span < 1:
            raise ValueError(f"SpanEstimate.span is {self.span}; allowed: from 1")

    @property
    def z(self) -> Real:
        """Amplitudes in their standard deviations, (C,)."""
        found: Real = self.amplitude / self.sigma
        return found


def span_estimate(dates: Sequence[DateEquations], variance: Real, prior: Real) -> SpanEstimate:
    """Estimate amplitudes from some dates together.

    Parameters
    ----------
    dates : sequence of DateEquations
    variance : (C,) ndarray
        Common to all dates, see `SelfCheck`.
    prior : (C,) ndarray
        Usual amplitudes, SI.
    """
    information = np.sum([np.diag(one.matrix) for one in dates], axis=0)
    pull = np.sum([one.gradient for one in dates], axis=0)
    seen = information * prior**2 > LEAST_SEEN
    safe = np.where(seen, information, 1.0)
    sigma = np.where(seen, np.sqrt(1.0 / safe + variance), np.inf)
    return SpanEstimate(len(dates), np.where(seen, pull / safe, 0.0), sigma)


def spans(count: int) -> list[int]:
    """Numbers of last dates that are added up when there are `count`."""
    return [span for span in SPANS if span <= count]


def limit(rate: float, two_sided: Mask) -> float:
    """Largest z of a healthy panel, exceeded on one date with a probability of at most the rate's share.

    Parameters
    ----------
    rate : float
        False alarms per date.
    two_sided : (C,) bool ndarray
        Candidates whose amplitude may be negative: two tests each.
    """
    tests = len(SPANS) * (two_sided.size + int(two_sided.sum()))
    return float(norm.isf((1.0 - SHARE_OF_UNKNOWN) * rate / max(tests, 1)))


def misfit_limit(rate: float, largest: float, dof: int) -> float:
    """Chi2 per degree of freedom beyond which a date shows a change that nothing explains.

    Parameters
    ----------
    rate : float
        False alarms per date.
    largest : float
        Chi2 per degree of freedom that the healthy panel has at most, see `SelfCheck`.
    dof : int
    """
    from scipy.stats import chi2

    return float(MISFIT_MARGIN * largest * chi2.isf(SHARE_OF_UNKNOWN * rate, dof) / dof)
