"""Closed outlines as declared, of plates, holes and thickness zones, and whether they fit together.

A drawing (``kind = "drawing"``) is turned into ``kind = "curves"`` when its file is read, so that a declaration
holds the geometry itself and no path.

What holds a plate: along whole edges, along parts of them, or at points; and whether each finds its place.
"""

from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import ConfigDict, Field, model_validator

from analysis.declaration.strict import Coordinate, Declared, Degrees, Point, Sparse, Thickness
from analysis.geometry.loop import (
    Arc,
    Cubic,
    Curve,
    GeometryError,
    Loop,
    Segment,
    at,
    circle,
    closed_spline,
    ellipse,
    polygon,
    rectangle,
)
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
        return rectangle(self.center, self.size, float(np.deg2rad(self.angle)))


class PolygonOutline(Outline):
    """A polygon; curve k runs from point k to the next."""

    kind: Literal["polygon"]
    points: Annotated[tuple[Point, ...], Field(min_length=3, max_length=MOST_POINTS, description="m")]

    def make(self) -> Loop:
        """Make the loop."""
        return polygon(self.points)


class CircleOutline(Outline):
    """A circle, in four arcs from its rightmost point on."""

    kind: Literal["circle"]
    center: Point
    radius: Radius

    def make(self) -> Loop:
        """Make the loop."""
        return circle(self.center, self.radius)


class EllipseOutline(Outline):
    """An ellipse, its first semi-axis turned by `angle` against x; in four arcs from the end of that axis on."""

    kind: Literal["ellipse"]
    center: Point
    radii: tuple[Radius, Radius]
    angle: Degrees = 0.0

    def make(self) -> Loop:
        """Make the loop."""
        return ellipse(self.center, self.radii, float(np.deg2rad(self.angle)))


class SplineOutline(Outline):
    """A smooth curve through points: a periodic cubic spline; curve k runs from point k to the next."""

    kind: Literal["spline"]
    points: Annotated[tuple[Point, ...], Field(min_length=4, max_length=MOST_POINTS, description="m")]

    def make(self) -> Loop:
        """Make the loop."""
        return closed_spline(self.points)


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
    disc = circle(point, radius)
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


SupportKind = Literal["free", "soft-simple", "hard-simple", "clamped", "elastic"]
Stiffness = Annotated[float, Field(ge=0.0, le=1e12)]
Piece = tuple[int, float, float]
"""A part of a curve of a loop: which, from 0, and its first and last parameter, ascending."""

SIDES = {"bottom": 0, "right": 1, "top": 2, "left": 3}
"""Curves of a rectangle by their names."""
LARGEST_EDGE_DISTANCE = 5e-4
"""How far from the edge the end of a supported part may be declared, m."""
SHORTEST_PART = 1e-4
"""Length of the shortest part that can be supported, m."""


class Support(Sparse):
    """A support of an edge, of a part of one, or at a point.

    Where it holds: `edge` (``"left"``, ``"right"``, ``"bottom"`` or ``"top"`` of a rectangle, the number of a
    curve of the outline from 1, or ``"all"``); from `from` to `to` counter-clockwise along the edge; or at
    `point`, over a disc of `radius`. With `hole` = n, the edge is that of hole n; `hole` alone means all of it.

    What it holds: ``soft-simple`` the deflection, ``hard-simple`` the rotation along the edge besides, ``clamped``
    everything. ``elastic`` resists the deflection with `translation` (N/m2) and `damping` (N s/m2), the rotation
    about the edge with `rotation` (N m/rad per m) and `rotation_damping` (N m s/rad per m); at a point the
    deflection only, with `stiffness` (N/m) and `damping` (N s/m). ``free`` takes back what a support before it
    holds. Where two meet, the later one counts.
    """

    model_config = ConfigDict(validate_by_name=True, validate_by_alias=True, serialize_by_alias=True)

    kind: SupportKind
    edge: Annotated[int, Field(ge=1)] | Literal["left", "right", "bottom", "top", "all"] | None = None
    hole: Annotated[int, Field(ge=1)] | None = None
    start: Annotated[Point | None, Field(alias="from", description="m")] = None
    end: Annotated[Point | None, Field(alias="to", description="m")] = None
    point: Annotated[Point | None, Field(description="m")] = None
    radius: Annotated[float, Field(ge=5e-4, le=0.1, description="m")] = 0.002
    translation: Annotated[Stiffness, Field(description="N/m2")] = 0.0
    rotation: Annotated[Stiffness, Field(description="N m/rad per m")] = 0.0
    stiffness: Annotated[Stiffness, Field(description="N/m")] = 0.0
    damping: Annotated[Stiffness, Field(description="N s/m2 along an edge, N s/m at a point")] = 0.0
    rotation_damping: Annotated[Stiffness, Field(description="N m s/rad per m")] = 0.0

    @property
    def at_point(self) -> bool:
        """Whether it holds at a point and not along an edge."""
        return self.point is not None

    @model_validator(mode="after")
    def _somewhere(self) -> Self:
        if (self.start is None) != (self.end is None):
            raise ValueError("from and to belong together; one of them is missing")
        ways = [name for name in ("edge", "start", "point") if getattr(self, name) is not None]
        keys = {"edge": "edge", "start": "from and to", "point": "point"}
        if len(ways) > 1:
            raise ValueError(f"{' and '.join(keys[way] for way in ways)} name different places; keep one of them")
        if not ways and self.hole is None:
            raise ValueError("the support names no place; give edge, hole, from and to, or point")
        if self.at_point and self.hole is not None:
            raise ValueError("point and hole name different places; keep one of them")
        if "radius" in self.model_fields_set and not self.at_point:
            raise ValueError("radius belongs to a support at a point")
        return self

    @model_validator(mode="after")
    def _holds(self) -> Self:
        if self.at_point and self.kind in ("free", "hard-simple"):
            raise ValueError(f"{self.kind} has no meaning at a point; allowed clamped, soft-simple or elastic")
        springs = (
            ("stiffness", "damping")
            if self.at_point
            else ("translation", "rotation", "damping", "rotation_damping")
        )
        given = [
            name
            for name in ("translation", "rotation", "stiffness", "damping", "rotation_damping")
            if getattr(self, name) > 0.0
        ]
        if self.kind == "elastic":
            wrong = [name for name in given if name not in springs]
            if wrong:
                place = "at a point" if self.at_point else "along an edge"
                raise ValueError(f"{wrong[0]} has no meaning {place}; allowed {', '.join(springs)}")
            if not given:
                raise ValueError(
                    f"elastic, but nothing holds: give {', '.join(springs[:-1])} or {springs[-1]} above 0"
                )
        elif given:
            raise ValueError(f"{given[0]} belongs to kind elastic, not to {self.kind}")
        return self

    def pieces(self, loop: Loop, names: bool) -> tuple[Piece, ...]:
        """Return the parts of a loop that an edge's support holds; GeometryError where there is nothing.

        Parameters
        ----------
        names : bool
            Whether its curves are those of a rectangle, which have names.
        """
        count = len(loop.curves)
        if self.start is not None and self.end is not None:
            return _between(loop, self.start, self.end)
        if self.edge is None or self.edge == "all":
            return tuple((k, 0.0, 1.0) for k in range(count))
        if isinstance(self.edge, str):
            if not names:
                raise ValueError(
                    f"edge {self.edge!r} is that of a rectangle; this outline has the edges 1 to {count} and all"
                )
            return ((SIDES[self.edge], 0.0, 1.0),)
        if self.edge > count:
            raise ValueError(f"edge {self.edge} does not exist; this outline has the edges 1 to {count}")
        return ((count - self.edge if loop.turned else self.edge - 1, 0.0, 1.0),)


def _between(loop: Loop, start: Point, end: Point) -> tuple[Piece, ...]:
    near = loop.nearest(np.array([start, end]))
    for name, place, there, far in zip(("from", "to"), (start, end), near.points, near.distance, strict=True):
        if far > LARGEST_EDGE_DISTANCE:
            raise GeometryError(
                f"{name} {at(place)} lies {1e3 * far:.3g} mm off the edge, nearest to it at {at(there)}; "
                f"allowed {1e3 * LARGEST_EDGE_DISTANCE:g} mm",
                place,
            )
    (first, last), (t0, t1) = near.curve.tolist(), near.t.tolist()
    if np.hypot(*(near.points[1] - near.points[0])) < SHORTEST_PART:
        raise GeometryError(
            f"from and to are the same place of the edge, {at(near.points[0])}: the part has no length; for "
            'all of an edge say edge = "all"',
            near.points[0],
        )
    if first == last and t0 < t1:
        return ((first, t0, t1),)
    count = len(loop.curves)
    between = [(first + k) % count for k in range(1, (last - first) % count or count)]
    pieces = [(first, t0, 1.0), *((k, 0.0, 1.0) for k in between), (last, 0.0, t1)]
    return tuple((k, a, b) for k, a, b in pieces if b - a > 1e-9)


Pieces = Callable[[Support], tuple[Piece, ...]]
"""Parts of a plate's edge that a support along it holds; see `Support.pieces`."""

NEAR_THE_EDGE = "move it, choose a smaller radius, or hold a part of the edge with from and to"


@dataclass(frozen=True)
class SupportedEdge:
    """Where one support holds.

    Attributes
    ----------
    support : Support
    loop : int
        0 for the outline, n for the n-th hole.
    pieces : tuple of (int, float, float)
        Curves of that loop, from 0, with the first and last parameter of the part held.
    """

    support: Support
    loop: int
    pieces: tuple[Piece, ...]


def supported_edges(supports: Sequence[Support], pieces: Pieces) -> list[SupportedEdge]:
    """Return what supports hold along the edges; where two meet, the later one counts."""
    found: list[SupportedEdge] = []
    for support in supports:
        if support.at_point:
            continue
        number, held = support.hole or 0, pieces(support)
        found = [replace(one, pieces=_without(one.pieces, held)) if one.loop == number else one for one in found]
        found.append(SupportedEdge(support, number, held))
    return [one for one in found if one.pieces and one.support.kind != "free"]


def check_supports(supports: Sequence[Support], outline: Loop, holes: Sequence[Loop], pieces: Pieces) -> None:
    """Check that every support finds its place on a plate.

    Parameters
    ----------
    pieces : callable
        Parts of the edge that a support holds.

    Raises
    ------
    ValueError
        For a hole or an edge that the plate does not have; `GeometryError`, with the place, for a disc that does
        not lie on the plate and ends off the edge.
    """
    for number, support in enumerate(supports):
        if support.hole is not None and support.hole > len(holes):
            raise ValueError(f"support[{number}]: hole {support.hole} does not exist; the plate has {len(holes)}")
        if support.point is not None:
            check_disc(f"support[{number}]", support.point, support.radius, outline, holes, NEAR_THE_EDGE)
            continue
        try:
            pieces(support)
        except GeometryError as error:
            raise GeometryError(f"support[{number}]: {error}", *error.places) from error
        except ValueError as error:
            raise ValueError(f"support[{number}]: {error}") from error


def _without(pieces: tuple[Piece, ...], taken: tuple[Piece, ...]) -> tuple[Piece, ...]:
    """Return `pieces` less what `taken` covers of them."""
    left = list(pieces)
    for curve, first, last in taken:
        cut: list[Piece] = []
        for number, low, high in left:
            if number != curve or last <= low or first >= high:
                cut.append((number, low, high))
                continue
            cut += [(number, a, b) for a, b in ((low, first), (last, high)) if b > a]
        left = cut
    return tuple(left)
