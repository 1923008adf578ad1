"""What is wrong with a geometry, and where."""

import numpy as np
from numpy.typing import ArrayLike


class GeometryError(ValueError):
    """A geometry that is impossible; the message contains the remedy.

    Attributes
    ----------
    places : tuple of (float, float)
        Where, m.
    """

    def __init__(self, message: str, *places: ArrayLike) -> None:
        super().__init__(message)
        self.places: tuple[tuple[float, float], ...] = tuple(
            (float(x), float(y)) for x, y in (np.asarray(place, float) for place in places)
        )


def at(place: ArrayLike) -> str:
    """Write a place in a message: "(0.12, 0.05) m"."""
    x, y = np.asarray(place, float)
    return f"({x:.6g}, {y:.6g}) m"
