"""An axis that, where it is logarithmic, shows plain numbers, as many as have room."""

import numpy as np
import pyqtgraph
from numpy.typing import ArrayLike

from analysis.arrays import Real

LEAST_NUMBER_DISTANCE = 44.0
"""Dots between numbers at least."""
LABELLED_NUMBERS = ((1, 2, 3, 4, 5, 6, 7, 8, 9), (1, 2, 3, 5, 7), (1, 2, 5), (1, 3), (1,))
"""Numbers of a decade that are labelled, the largest choice first."""
NARROW_DECADES = 0.3
"""Decades below which the numbers stand at equal distances."""


def log_places(values: ArrayLike, lines: Real) -> Real:
    """Return the decadic logarithm of values; a line at 0, and what lies below it, stands at half the next line.

    Parameters
    ----------
    values : array_like
        Where cursors or columns stand, Hz.
    lines : (F,) ndarray
        Frequencies of the axis, Hz, at least one of them above 0.

    Returns
    -------
    ndarray
        Shaped as `values`, finite.
    """
    places: Real = np.log10(np.maximum(values, 0.5 * lines[lines > 0.0].min()))
    return places


class LogAxis(pyqtgraph.AxisItem):
    """Ticks of a logarithmic axis; a linear one is as pyqtgraph has it."""

    def logTickValues(
        self, minVal: float, maxVal: float, size: float, stdTicks: object
    ) -> list[tuple[float | None, list[float]]]:
        """Return ticks with a number, then those without, as pyqtgraph asks for them.

        Parameters
        ----------
        minVal, maxVal : float
            Ends of the axis, as decadic logarithms.
        size : float
            Its length, dots.
        stdTicks : object
            Those of a linear axis; not used.

        Returns
        -------
        list of (float or None, list of float)
            Spacing, None for ticks without a number, and decadic logarithms.
        """
        decades = max(maxVal - minVal, 1e-9)
        if decades < NARROW_DECADES:
            low, high = 10.0**minVal, 10.0**maxVal
            finest = (high - low) * LEAST_NUMBER_DISTANCE / size
            power = 10.0 ** np.floor(np.log10(finest))
            step = power * next(n for n in (1.0, 2.0, 5.0, 10.0) if n * power >= finest)
            return [(1.0, np.log10(step * np.arange(np.ceil(low / step), high / step)).tolist())]
        below, above = int(np.floor(minVal)), int(np.ceil(maxVal))
        for labelled in LABELLED_NUMBERS:
            gap = float(np.diff(np.log10([*labelled, 10])).min()) * size / decades
            if gap >= LEAST_NUMBER_DISTANCE:
                break
        ticks = {n: [power + float(np.log10(n)) for power in range(below, above + 1)] for n in range(1, 10)}
        shown = {n: [v for v in row if minVal <= v <= maxVal] for n, row in ticks.items()}
        return [
            (1.0, [v for n in labelled for v in shown[n]]),
            (None, [v for n in ticks if n not in labelled for v in shown[n]]),
        ]

    def logTickStrings(self, values: list[float], scale: float, spacing: float | None) -> list[str]:
        """Return the numbers, or nothing for ticks without.

        Parameters
        ----------
        values : list of float
            Decadic logarithms.
        scale : float
            Factor of the numbers.
        spacing : float or None
            Of the ticks; None for those without a number.
        """
        return ["" if spacing is None else f"{scale * 10.0**v:.6g}" for v in values]
