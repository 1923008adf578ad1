"""Cubic B-splines by the recurrence of Cox and de Boor.

`scipy.interpolate` has them too, and with its optimisers and transforms takes a third of a second of processor
time to import, which every verb that reads laws would pay.
"""

import numpy as np

from analysis.arrays import Real


def cubic_basis(place: Real, knots: Real) -> Real:
    """Values (T, n) of n B-splines of degree 3 at `place` (T,), within `knots` (n + 4,) of fourfold ends."""
    span = np.clip(np.searchsorted(knots, place, side="right") - 1, 3, len(knots) - 5)
    values = np.ones((len(place), 1))
    for degree in (1, 2, 3):
        lower, upper = (
            knots[span[:, None] + np.arange(1 - degree, 1)],
            knots[span[:, None] + np.arange(1, degree + 1)],
        )
        share = values / (upper - lower)
        values = np.zeros((len(place), degree + 1))
        values[:, :-1] = (upper - place[:, None]) * share
        values[:, 1:] += (place[:, None] - lower) * share
    found = np.zeros((len(place), len(knots) - 4))
    found[np.arange(len(place))[:, None], span[:, None] + np.arange(-3, 1)] = values
    return found
