"""Closed outlines as declared, of plates, holes and thickness zones, and whether they fit together.

A drawing (``kind = "drawing"``) is turned into ``kind = "curves"`` when its file is read, so that a declaration
holds the geometry itself and no path.
"""

from abc import abstractmethod
from collections.abc import Sequence
from functools import cached_property
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from analysis.declaration.strict import Coordinate, Declared, Degrees, Point, Thickness
from analysis.geometry import shapes
from analysis.geometry.loop import Arc, Cubic, Curve, GeometryError, Loop, Segment, at
from analysis.geometry.relations import TOUCH, gap, leaves, overlap, self_crossing

Extent = Annotated[float, Field(ge=0.001, le=5.0, description="m")]
Radius = Annotated[float, Field(ge=0.0005, le=5.0, description="m")]
Row = Annotated[tuple[Coordinate, ...], Field(min_length=4, max_length=8)]
MOST_POINTS = 1000
"""Points of a polygon or a spline, and curves of an outline: more is a defective export."""


class Outline(Declared):
    """A closed chain of curves that neither crosses nor touches itself."""

    @abstractmethod
    def make(self) -> Loop:
        """Make the loop."""

    @cached_property
    def loop(self) -> Loop:
        """The outline as a loop, counter-clockwise."""
        return self.make()

    @model_validator(mode="after")
    def _closed_and_simple(self) -> Self:
        loop = self.loop
        for number, curve in enumerate(loop.curves):
            if np.hypot(*curve.derivative(np.linspace(0.05, 0.95, 7)).T).max() <= TOUCH:
                point = curve.at(0.0)
                raise GeometryError(
                    f"curve {number + 1} of the outline has no length, at {at(point)}: remove a point", point
                )
        place = self_crossing(loop)
        if place is not None:
            raise GeometryError(
                f"the outline crosses or touches itself at {at(place)}; give its points in the order in which "
                "they follow each other around it",
                place,
            )
        return self


class RectangleOutline(Outline):
    """A rectangle, its first side turned by `angle` against x."""

    kind: Literal["rectangle"]
    center: Point
    size: tuple[Extent, Extent]
    angle: Degrees = 0.0

    def make(self) -> Loop:
        """Make the loop: curves bottom, right, top, left, as seen before it is turned."""
        return shapes.rectangle(self.center, self.size, float(np.deg2rad(self.angle)))


class PolygonOutline(Outline):
    """A polygon; curve k runs from point k to the next."""

    kind: Literal["polygon"]
    points: Annotated[tuple[Point, ...], Field(min_length=3, max_length=MOST_POINTS, description="m")]

    def make(self) -> Loop:
        """Make the loop."""
        return shapes.polygon(self.points)


class CircleOutline(Outline):
    """A circle, in four arcs from its rightmost point on."""

    kind: Literal["circle"]
    center: Point
    radius: Radius

    def make(self) -> Loop:
        """Make the loop."""
        return shapes.circle(self.center, self.radius)


class EllipseOutline(Outline):
    """An ellipse, its first semi-axis turned by `angle` against x; in four arcs from the end of that axis on."""

    kind: Literal["ellipse"]
    center: Point
    radii: tuple[Radius, Radius]
    angle: Degrees = 0.0

    def make(self) -> Loop:
        """Make the loop."""
        return shapes.ellipse(self.center, self.radii, float(np.deg2rad(self.angle)))


class SplineOutline(Outline):
    """A smooth curve through points: a periodic cubic spline; curve k runs from point k to the next."""

    kind: Literal["spline"]
    points: Annotated[tuple[Point, ...], Field(min_length=4, max_length=MOST_POINTS, description="m")]

    def make(self) -> Loop:
        """Make the loop."""
        return shapes.closed_spline(self.points)


class CurvesOutline(Outline):
    """Curves one after the other, each a row of numbers.

    4 numbers: a straight line, x and y of both ends. 8: a cubic Bezier curve, x and y of its four control points.
    7: a part of an ellipse, centre x and y, both semi-axes, angle of the first against x, eccentric angle at the
    beginning and what is added to it until the end (radians, positive: counter-clockwise). All else in m.
    """

    kind: Literal["curves"]
    curves: Annotated[tuple[Row, ...], Field(min_length=1, max_length=MOST_POINTS)]

    def make(self) -> Loop:
        """Make the loop."""
        return Loop(tuple(curve_of(row, number) for number, row in enumerate(self.curves)))


AnyOutline = Annotated[
    RectangleOutline | PolygonOutline | CircleOutline | EllipseOutline | SplineOutline | CurvesOutline,
    Field(discriminator="kind"),
]


class Thick(Declared):
    """What makes an outline a thickness zone: a part of the plate about the same mid-plane."""

    thickness: Thickness


class RectangleZone(RectangleOutline, Thick):
    """A rectangular zone."""


class PolygonZone(PolygonOutline, Thick):
    """A zone inside a polygon."""


class CircleZone(CircleOutline, Thick):
    """A round zone."""


class EllipseZone(EllipseOutline, Thick):
    """An elliptic zone."""


class SplineZone(SplineOutline, Thick):
    """A zone inside a smooth curve."""


class CurvesZone(CurvesOutline, Thick):
    """A zone inside a chain of curves."""


AnyZone = Annotated[
    RectangleZone | PolygonZone | CircleZone | EllipseZone | SplineZone | CurvesZone, Field(discriminator="kind")
]


def curve_of(row: tuple[float, ...], number: int = 0) -> Curve:
    """Return the curve given by a row of 4, 7 or 8 numbers; ValueError for another count."""
    if len(row) == 4:
        return Segment((row[0], row[1]), (row[2], row[3]))
    if len(row) == 7:
        if not (row[2] > 0.0 and row[3] > 0.0 and 0.0 < abs(row[6]) <= 2.0 * np.pi + 1e-9):
            raise ValueError(
                f"curves[{number}]: semi-axes {row[2]:g} and {row[3]:g} m must be above 0, and the angle added, "
                f"{row[6]:g} rad, neither 0 nor more than a full turn"
            )
        return Arc((row[0], row[1]), (row[2], row[3]), row[4], row[5], row[6])
    if len(row) == 8:
        return Cubic(((row[0], row[1]), (row[2], row[3]), (row[4], row[5]), (row[6], row[7])))
    raise ValueError(
        f"curves[{number}] has {len(row)} numbers; allowed 4 (straight line), 7 (elliptic arc) or 8 (cubic)"
    )


def row_of(curve: Curve) -> tuple[float, ...]:
    """Return the numbers that a curve is declared by; `curve_of` reads them."""
    if isinstance(curve, Segment):
        return (*curve.start, *curve.end)
    if isinstance(curve, Arc):
        return (*curve.center, *curve.radii, curve.rotation, curve.start, curve.sweep)
    return tuple(value for point in curve.control for value in point)


LEAST_EDGE_DISTANCE = 1e-4
"""Least distance between the edges of outline, holes and zones, m."""


def check_parts(outline: Loop, holes: Sequence[Loop], zones: Sequence[Loop]) -> None:
    """Check that all parts lie inside the outline and apart, holes clear of every other edge.

    Zones may reach to the outline, to holes and to each other, and hold all of a hole.

    Raises
    ------
    GeometryError
        For parts that reach out of the outline, overlap, cross or come too close, with the place.
    """
    cuts = [(f"hole {n + 1}", loop) for n, loop in enumerate(holes)]
    areas = [(f"zone {n + 1}", loop) for n, loop in enumerate(zones)]
    for name, loop in (*cuts, *areas):
        place = leaves(loop, outline)
        if place is not None:
            raise GeometryError(f"{name} reaches out of the outline at {at(place)}; move it inside", place)
        _require_clear(name, loop, "the outline", outline)
    for group in (cuts, areas):
        for k, (name, loop) in enumerate(group):
            for other_name, other in group[k + 1 :]:
                place = overlap(loop, other)
                if place is not None:
                    raise GeometryError(f"{name} and {other_name} overlap at {at(place)}; part them", place)
                _require_clear(name, loop, other_name, other)
    for name, zone in areas:
        for hole_name, hole in cuts:
            place = overlap(zone, hole)
            if place is not None and leaves(hole, zone) is not None:
                raise GeometryError(
                    f"{hole_name} crosses the border of {name} at {at(place)}; part them, or have the zone "
                    "hold all of the hole",
                    place,
                )
            _require_clear(name, zone, hole_name, hole)


def check_disc(
    name: str,
    point: tuple[float, float],
    radius: float,
    outline: Loop,
    holes: Sequence[Loop],
    remedy: str = "move it",
) -> None:
    """Check that a disc lies on a plate, over no edge.

    Parameters
    ----------
    name : str
        What is fixed there, for the message.
    point : (float, float)
        Centre, m.
    radius : float
        m; 0 for a point.
    remedy : str
        What to do where it reaches over an edge.

    Raises
    ------
    GeometryError
        For a centre off the plate or in a hole, and a disc that reaches over an edge, with the place.
    """
    here = np.array([point])
    in_hole = any(hole.contains(here)[0] and hole.nearest(here).distance[0] > TOUCH for hole in holes)
    if in_hole or not outline.contains(here, within=TOUCH)[0]:
        raise GeometryError(
            f"{name}: point {at(point)} is off the plate or in a hole; move it onto the plate", point
        )
    if not radius:
        return
    disc = shapes.circle(point, radius)
    place = leaves(disc, outline)
    for hole in holes:
        place = overlap(disc, hole) if place is None else place
    if place is not None:
        raise GeometryError(
            f"{name} at {at(point)}, radius {radius:g} m, reaches over the edge at {at(place)}; {remedy}",
            place,
        )


def _require_clear(name: str, loop: Loop, other_name: str, other: Loop) -> None:
    distance, place = gap(loop, other)
    if distance < LEAST_EDGE_DISTANCE and not (distance <= TOUCH and name.startswith("zone")):
        raise GeometryError(
            f"{name} and {other_name} are {1e3 * distance:.3g} mm apart at {at(place)}; allowed "
            f"{1e3 * LEAST_EDGE_DISTANCE:g} mm and more",
            place,
        )
