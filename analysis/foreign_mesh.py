"""A mesh made elsewhere, as a declaration holds it."""

from typing import Annotated

from pydantic import Field

from analysis.declared import Declared, Point

MOST_POINTS = 5000
"""Points of a mesh: functions of high degree need a few hundred."""
Number = Annotated[int, Field(ge=0, lt=MOST_POINTS)]
Cell = Annotated[int, Field(ge=0, lt=2 * MOST_POINTS)]


class ForeignMesh(Declared):
    """Triangles and quadrilaterals over a plate, straight or quadratic.

    A file (``file = "plate.msh"``) is turned into this when the declaration is read, so that a declaration holds
    the mesh itself and no path.

    Attributes
    ----------
    points
        x and y, m; points in the middle of quadratic edges among them.
    quads, triangles
        Corners of every cell.
    midsides
        Both ends of a quadratic edge, and the point in its middle.
    surface
        Cells, quadrilaterals counted first, of every physical surface by its name.
    curve
        Both ends of every edge on a physical curve, by its name.
    """

    points: Annotated[tuple[Point, ...], Field(min_length=3, max_length=MOST_POINTS)]
    quads: Annotated[tuple[tuple[Number, Number, Number, Number], ...], Field(max_length=MOST_POINTS)] = ()
    triangles: Annotated[tuple[tuple[Number, Number, Number], ...], Field(max_length=2 * MOST_POINTS)] = ()
    midsides: Annotated[tuple[tuple[Number, Number, Number], ...], Field(max_length=3 * MOST_POINTS)] = ()
    surface: Annotated[dict[str, tuple[Cell, ...]], Field(default_factory=dict, max_length=1000)]
    curve: Annotated[dict[str, tuple[tuple[Number, Number], ...]], Field(default_factory=dict, max_length=1000)]
