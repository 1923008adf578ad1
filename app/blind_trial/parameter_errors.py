"""Errors of estimated parameters, and coverage of their intervals."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from app.blind_trial.outcome import TrialOutcome

HALF_WIDTH_OF_90 = 1.6448536269514722
"""Half width of the 90 % interval of a normal distribution, in standard deviations."""


def errors(outcomes: Sequence[TrialOutcome]) -> NDArray[np.float64]:
    """Relative error of the one effect of each outcome, (N,).

    Its amplitudes count as one vector, in units of their priors, because a single component may be nearly zero (a
    gradient along x has almost none along y). Shape parameters are not included.
    """
    found = []
    for o in outcomes:
        ((name, scale),) = o.scale.items()
        true, estimate = o.effects[name], o.named[0].parameters
        size = np.linalg.norm([true[p] / sigma for p, sigma in scale.items()])
        off = np.linalg.norm([(estimate[p][0] - true[p]) / sigma for p, sigma in scale.items()])
        found.append(float(off / size))
    return np.array(found)


def coverage(outcomes: Sequence[TrialOutcome]) -> tuple[int, int]:
    """Count the parameters whose 90 % interval contains the truth, and all parameters."""
    inside = [
        abs(value - o.effects[named.name][parameter]) <= HALF_WIDTH_OF_90 * sigma
        for o in outcomes
        for named in o.named
        for parameter, (value, sigma) in named.parameters.items()
    ]
    return sum(inside), len(inside)
