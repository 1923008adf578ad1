"""What can be drawn of a declaration that is refused."""

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

from analysis.declaration.outline import (
    CircleOutline,
    EllipseOutline,
    Outline,
    PolygonOutline,
    RectangleOutline,
    SplineOutline,
    curve_of,
)
from analysis.declaration.patch import Patch
from analysis.declaration.support import Support
from analysis.geometry.curves import Curve
from analysis.geometry.loop import Loop
from app.files.bad_file import Misplaced
from app.report.declared import Pieces

KINDS: Mapping[str, type[Outline]] = {
    "rectangle": RectangleOutline,
    "polygon": PolygonOutline,
    "circle": CircleOutline,
    "ellipse": EllipseOutline,
    "spline": SplineOutline,
}
CANNOT = (ValueError, TypeError, KeyError, IndexError, AttributeError, ArithmeticError)
"""Results of settings that were not checked."""


def pieces_declared(wrong: Misplaced) -> Pieces:
    """Take what can be drawn of a declaration that is wrong; the rest is left out."""
    declared = wrong.declared
    table = declared.get("plate")
    plate: Mapping[str, Any] = table if isinstance(table, Mapping) else {}
    outline = _curves(plate["outline"]) if "outline" in plate else _rectangle(plate)
    patches = []
    for item in _tables(declared.get("patch")):
        try:
            patches.append((str(item.get("id")), Patch.model_validate(item).loop.curves))
        except CANNOT:
            continue
    held_at = [(str(item.get("kind")), item) for item in _tables(plate.get("support"))]
    fixed = [(name, item) for name in ("string", "cable") for item in _tables(declared.get(name))]
    points = [
        (name, (float(item["point"][0]), float(item["point"][1])))
        for name, item in (*fixed, *held_at)
        if _is_point(item.get("point"))
    ]
    return Pieces(
        outline=outline,
        holes=tuple(curve for item in _tables(plate.get("hole")) for curve in _curves(item)),
        zones=tuple(curve for item in _tables(plate.get("zone")) for curve in _curves(item)),
        patches=tuple(patches),
        points=tuple(points),
        held=_held(plate, outline),
        loose=wrong.loose,
        mesh=_cell_sides(plate.get("mesh")),
    )


def _tables(value: object) -> list[Mapping[str, Any]]:
    return [item for item in value if isinstance(item, Mapping)] if isinstance(value, list) else []


def _is_point(value: object) -> bool:
    return isinstance(value, list) and len(value) == 2 and all(isinstance(x, int | float) for x in value)


def _rectangle(plate: Mapping[str, Any]) -> tuple[Curve, ...]:
    try:
        a, b = float(plate["length_x"]), float(plate["length_y"])
        return _curves({"kind": "rectangle", "center": (0.5 * a, 0.5 * b), "size": (a, b), "angle": 0.0})
    except CANNOT:
        return ()


def _curves(declared: object) -> tuple[Curve, ...]:
    """Curves of an outline that was not checked; none where they cannot be made."""
    if not isinstance(declared, Mapping):
        return ()
    try:
        if declared.get("kind") == "curves":
            return tuple(curve_of(tuple(row)) for row in declared["curves"])
        given = {"angle": 0.0, **{key: _frozen(value) for key, value in declared.items() if key != "thickness"}}
        return KINDS[str(declared.get("kind"))].model_construct(**given).make().curves
    except CANNOT:
        return ()


def _cell_sides(mesh: object) -> tuple[Curve, ...]:
    """Sides of the cells of a mesh that was not checked, straight; none where they cannot be made."""
    if not isinstance(mesh, Mapping):
        return ()
    try:
        cells = [*mesh.get("quads", ()), *mesh.get("triangles", ())]
        pairs = {(min(a, b), max(a, b)) for cell in cells for a, b in pairwise([*cell, cell[0]])}
        points = mesh["points"]
        return tuple(curve_of((*points[a], *points[b])) for a, b in sorted(pairs))
    except CANNOT:
        return ()


def _frozen(value: Any) -> Any:
    return tuple(_frozen(item) for item in value) if isinstance(value, list) else value


def _held(plate: Mapping[str, Any], outline: tuple[Curve, ...]) -> tuple[tuple[str, Curve], ...]:
    """Return supported parts of the outline, as far as they can be determined."""
    found: list[tuple[str, Curve]] = []
    for item in _tables(plate.get("support")):
        try:
            support, loop = Support.model_validate(item), Loop(outline)
            if support.at_point or support.hole is not None:
                continue
            pieces = support.pieces(loop, names=len(outline) == 4)
        except CANNOT:
            continue
        found += [(support.kind, loop.curves[k].part(first, last)) for k, first, last in pieces]
    return tuple(found)
