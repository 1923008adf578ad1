"""A mesh under construction: points, quadrilaterals, and the loops around the area left to be filled."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from analysis.arrays import Real
from simulation.meshing.repairs import Stretch

Path = Callable[[Real], Real]
"""Points (..., 2) over a parameter in [0, 1]."""


@dataclass(frozen=True)
class Foot:
    """Origin of an inner point of a strip.

    Attributes
    ----------
    width : float
        Of the strip there, m.
    point : int
        Of the border.
    pieces : tuple of Stretch
        Pieces of the strip on both sides of it.
    """

    width: float
    point: int
    pieces: tuple[Stretch, ...]


@dataclass
class Cells:
    """A mesh under construction: points, quadrilaterals, curved edges and the loops left to be filled."""

    points: list[Real] = field(default_factory=list)
    quads: list[tuple[int, int, int, int]] = field(default_factory=list)
    quad_face: list[int] = field(default_factory=list)
    paths: dict[tuple[int, int], Path] = field(default_factory=dict)
    """Curved edges, by their two points."""
    on_edge: dict[tuple[int, int], tuple[int, float, float]] = field(default_factory=dict)
    """Pieces by their two points -> edge of the arrangement and parameters at these points."""
    rings: list[list[list[int]]] = field(default_factory=list)
    """Rings of points around the area to be filled, by face."""
    inner: dict[tuple[int, int], tuple[int, int]] = field(default_factory=dict)
    """Sides of rings, ascending -> the piece from which their strip starts."""
    foot: dict[int, Foot] = field(default_factory=dict)
    """Origin of every inner point of a strip."""
    wedges: list[tuple[int, int, int]] = field(default_factory=list)
    """Triangles in which strips end."""
    wedge_face: list[int] = field(default_factory=list)
    corners: dict[int, bool] = field(default_factory=dict)
    """Points at which the mesh can be graded -> whether it is a convex corner of the plate alone."""

    def add(self, point: Real) -> int:
        """Append a point and return its number."""
        self.points.append(np.asarray(point, float))
        return len(self.points) - 1
