"""What a plot of a map shows."""

from dataclasses import dataclass

from analysis.arrays import Real


@dataclass(frozen=True)
class Map:
    """Values over a grid.

    Attributes
    ----------
    x, y : (C,), (R,) ndarray
        Centres of columns and rows.
    value : (R, C) ndarray
    """

    x: Real
    y: Real
    value: Real
