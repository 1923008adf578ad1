"""How far estimated parameters are from what was hidden, and whether their intervals hold it."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from app.blind_trial.outcome import TrialOutcome

NINETY = 1.6448536269514722
"""Standard deviations that hold 90 % of a normal distribution."""


def errors(outcomes: Sequence[TrialOutcome]) -> NDArray[np.float64]:
    """Relative error of the one effect of each outcome, (N,).

    Its amplitudes count as one vector, in units of their priors: of a gradient along x the part along y is nearly
    zero, and relative to itself would say nothing. Shapes take no part.
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
    """Parameters whose 90 % interval holds the truth, and all of them."""
    inside = [
        abs(value - o.effects[named.name][parameter]) <= NINETY * sigma
        for o in outcomes
        for named in o.named
        for parameter, (value, sigma) in named.parameters.items()
    ]
    return sum(inside), len(inside)
