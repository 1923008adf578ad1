"""Allowed positions of outline, holes and thickness zones of a plate, and of discs on it."""

from collections.abc import Sequence

import numpy as np

from analysis.geometry import shapes
from analysis.geometry.curves import Point
from analysis.geometry.fault import GeometryError, at
from analysis.geometry.loop import Loop
from analysis.geometry.relations import TOUCH, gap, leaves, overlap

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
    name: str, point: Point, radius: float, outline: Loop, holes: Sequence[Loop], remedy: str = "move it"
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
