"""What is fixed to a plate, held against it: every patch and point in a place where it can be."""

from collections.abc import Sequence

import numpy as np

from analysis.declared import Point
from analysis.geometry.fault import GeometryError, at
from analysis.geometry.relations import leaves, overlap
from analysis.patch import Patch
from analysis.plate import Plate


def check_patches(plate: Plate, patches: Sequence[Patch]) -> None:
    """Raise ValueError unless every patch has its own name and place, on the plate and over no edge of it."""
    names = [p.id for p in patches]
    for name in names:
        if name == "drive":
            raise ValueError("patch 'drive' has the name of the drive's channel; choose another id")
        if names.count(name) > 1:
            raise ValueError(f"patch id {name!r} is used {names.count(name)} times")
    for patch in patches:
        _check_place(plate, patch)
    for i, first in enumerate(patches):
        for second in patches[i + 1 :]:
            place = overlap(first.loop, second.loop) if first.side == second.side else None
            if place is not None:
                raise GeometryError(
                    f"patches {first.id!r} and {second.id!r} overlap on the {first.side} face at {at(place)}; "
                    "part them",
                    place,
                )


def _check_place(plate: Plate, patch: Patch) -> None:
    place = leaves(patch.loop, plate.loop)
    for axis, (low, high) in enumerate(zip(*plate.bounds, strict=True)):
        first, last = patch.span(axis)
        if first < low - 1e-9 or last > high + 1e-9:
            raise GeometryError(
                f"patch {patch.id!r} spans {first:g} to {last:g} m along {'xy'[axis]}; "
                f"the plate allows {low:g} to {high:g}",
                patch.center if place is None else place,
            )
    if place is not None:
        raise GeometryError(f"patch {patch.id!r} reaches over the plate's edge at {at(place)}; move it", place)
    for number, hole in enumerate(plate.hole_loops):
        place = overlap(patch.loop, hole)
        if place is not None:
            raise GeometryError(
                f"patch {patch.id!r} reaches into hole {number + 1} at {at(place)}; move it", place
            )
    for number, zone in enumerate(plate.zone_loops):
        place = overlap(patch.loop, zone)
        beyond = None if place is None else leaves(patch.loop, zone)
        if beyond is not None:
            raise GeometryError(
                f"patch {patch.id!r} lies partly on zone {number + 1} and partly beside it, at {at(beyond)}; "
                "it has to lie on one thickness",
                beyond,
            )


def check_point(plate: Plate, name: str, point: Point) -> None:
    """Check that a point lies on the plate.

    Parameters
    ----------
    name : str
        What is fixed there, for the message.
    point : (float, float)
        m.

    Raises
    ------
    GeometryError
        For a point in a hole or off the plate.
    """
    if plate.contains(np.array([point]))[0]:
        return
    for number, hole in enumerate(plate.hole_loops):
        if hole.contains(np.array([point]))[0]:
            raise GeometryError(f"{name} {list(point)} m is in hole {number + 1}; move it onto the plate", point)
    raise GeometryError(f"{name} {list(point)} m is off the plate", point)
