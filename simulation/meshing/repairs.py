"""Changes after a failed round of meshing: further cuts, narrower strips, borders without a strip."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Real
from simulation.meshing.arrangement import Corner, HalfEdge


@dataclass(frozen=True)
class Stretch:
    """A part of one side of an edge, between two ascending parameters of the edge's curve."""

    half: HalfEdge
    first: float
    last: float


@dataclass(frozen=True)
class Cap:
    """A place, (x, y) m, near which strips were too wide, and the largest width there, m."""

    place: tuple[float, float]
    width: float


@dataclass(frozen=True)
class Repairs:
    """Changes from earlier rounds of meshing.

    Attributes
    ----------
    splits : mapping
        Further parameters at which edges are cut, by edge.
    caps : tuple of Cap
    bare : frozenset of Stretch
        Parts of borders without a strip.
    """

    splits: Mapping[int, frozenset[float]]
    caps: tuple[Cap, ...]
    bare: frozenset[Stretch]

    def without_strip(self, half: HalfEdge, place: float) -> bool:
        """Whether the strip to the left of a half-edge is left out at a parameter of its edge's curve."""
        return any(s.half == half and s.first - 1e-9 <= place <= s.last + 1e-9 for s in self.bare)

    def closed(self, corner: Corner) -> bool:
        """Whether strips end at a corner, because one of them is left out there."""
        ends = ((corner.before, not corner.before.backward), (corner.after, corner.after.backward))
        return any(self.without_strip(half, float(at_end)) for half, at_end in ends)

    def widest(self, places: Real) -> Real:
        """Largest width of strips allowed at places (..., 2), (...), m."""
        found = np.full(np.shape(places)[:-1], np.inf)
        for cap in self.caps:
            away = np.asarray(places) - np.asarray(cap.place)
            found = np.minimum(found, cap.width + 0.4 * np.hypot(away[..., 0], away[..., 1]))
        return found
