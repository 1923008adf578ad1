"""What holds a plate: along whole edges, along parts of them, or at points; and whether each finds its place."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import ConfigDict, Field, model_validator

from analysis.declaration.outline import check_disc
from analysis.declaration.strict import Point, Sparse
from analysis.geometry.loop import GeometryError, Loop, at

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
