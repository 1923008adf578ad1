"""Curves with gaps, drawn as lines: what of them can be seen."""

import numpy as np

from analysis.arrays import Real


def in_lines(values: Real) -> Real:
    """Return values along the first axis, of any shape, without those alone between gaps (NaN).

    No line leads to those, so that the range of a plot of lines must not reach for them: of a tracked mode they
    often belong to another mode.
    """
    known = np.isfinite(values)
    beside = np.zeros_like(known)
    beside[1:] |= known[:-1]
    beside[:-1] |= known[1:]
    return np.where(known & beside, values, np.nan)
