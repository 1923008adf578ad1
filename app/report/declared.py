"""A plate as declared, drawn, and where any of it is wrong; what can be drawn of one that is refused."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from analysis.arrays import Real
from analysis.declaration.outline import (
    CircleOutline,
    EllipseOutline,
    Outline,
    PolygonOutline,
    RectangleOutline,
    SplineOutline,
    Support,
    curve_of,
)
from analysis.declaration.plate import Plate
from analysis.declaration.transducers import Patch
from analysis.experiment import Experiment
from analysis.geometry.loop import Curve, Loop, Point
from app.files.bad_file import Misplaced
from app.report.style import BAND, MEASURED, MODEL, drawing, panels

DRIVEN, READ = "#d55e00", "#0072b2"
"""Colours of points that are driven, and of points that are measured."""
POINTS_IN_SMALL_PRINT = 60
"""Points from which on their names are printed small."""
MARKS = {"string": "v", "cable": "D"}
HELD = {
    "clamped": "#222222",
    "hard-simple": "#cc79a7",
    "soft-simple": "#e69f00",
    "elastic": "#009e73",
    "free": "0.7",
}


@dataclass(frozen=True)
class Pieces:
    """All of a declaration that can be drawn.

    Attributes
    ----------
    outline, holes, zones, loose : tuple of Curve
    patches : tuple of (str, tuple of Curve)
        With their names.
    points : tuple of (str, (float, float))
        Strings, cables and supports at points.
    drives, read : tuple of (str, (float, float))
        Points that are driven and that are measured, with the names of their channels.
    held : tuple of (str, Curve)
        Parts of edges, with the kind of support.
    mesh : tuple of Curve
        Sides of the cells of a declared mesh.
    """

    outline: tuple[Curve, ...]
    holes: tuple[Curve, ...] = ()
    zones: tuple[Curve, ...] = ()
    patches: tuple[tuple[str, tuple[Curve, ...]], ...] = ()
    points: tuple[tuple[str, Point], ...] = ()
    drives: tuple[tuple[str, Point], ...] = ()
    read: tuple[tuple[str, Point], ...] = ()
    held: tuple[tuple[str, Curve], ...] = ()
    loose: tuple[Curve, ...] = ()
    mesh: tuple[Curve, ...] = ()


def pieces_of(plate: Plate, patches: Iterable[Patch]) -> Pieces:
    """Take the pieces of a plate that is declared rightly, to be drawn."""
    loops = (plate.loop, *plate.hole_loops)
    return Pieces(
        outline=plate.loop.curves,
        holes=tuple(curve for loop in plate.hole_loops for curve in loop.curves),
        zones=tuple(curve for loop in plate.zone_loops for curve in loop.curves),
        patches=tuple((patch.id, patch.loop.curves) for patch in patches),
        points=tuple((s.kind, s.point) for s, _ in plate.supported_discs().values() if s.point),
        held=tuple(
            (edge.support.kind, loops[edge.loop].curves[k].part(first, last))
            for edge in plate.supported_edges()
            for k, first, last in edge.pieces
        ),
    )


def pieces_of_experiment(experiment: Experiment) -> Pieces:
    """Take the pieces of an experiment: its plate, strings, cables, forces and motions."""
    plate, pieces = experiment.plate, pieces_of(experiment.plate, experiment.patch)
    named = (("string", experiment.string), ("cable", experiment.cable))
    attached = [(name, one.point) for name, items in named for one in items]
    channels = [channel for sensor in experiment.sensor for channel in sensor.channels(plate)]
    return replace(
        pieces,
        points=(*attached, *pieces.points),
        drives=tuple((drive.id, drive.point) for drive in experiment.drive),
        read=tuple((channel.id, channel.footprint.point) for channel in channels if channel.footprint),
    )


def picture(pieces: Pieces, wrong: Sequence[Point] = ()) -> Figure:
    """Draw the pieces, m, and a ring around every place that is wrong."""
    with drawing():
        figure, axes = panels(1, 1, width=7.0, height=5.5)
        _lines(axes, pieces.mesh, "mesh", color="0.65", lw=0.5)
        _lines(axes, pieces.zones, "zones", color="#56b4e9", ls="--", lw=1.2)
        for number, (name, curves) in enumerate(pieces.patches):
            points = _along(curves)
            axes.fill(*points.T, color=BAND, alpha=0.7, lw=0.0, label=None if number else "patches")
            axes.annotate(name, points.mean(axis=0), ha="center", va="center", fontsize=8.5)
        _lines(axes, pieces.outline, "plate", color="0.3", lw=2.0)
        _lines(axes, pieces.holes, "holes", color="0.3", lw=1.2)
        _lines(axes, pieces.loose, "drawing", color="#cc79a7", lw=1.2)
        for kind, color in HELD.items():
            _lines(
                axes, [curve for held, curve in pieces.held if held == kind], kind, color=color, lw=4.5, alpha=0.6
            )
        for name in dict.fromkeys(name for name, _ in pieces.points):
            places = np.array([place for other, place in pieces.points if other == name])
            axes.plot(*places.T, MARKS.get(name, "P"), color=HELD.get(name, MEASURED), ms=7, label=name)
        _named(axes, pieces.read, "measured", marker="o", color=READ)
        _named(axes, pieces.drives, "driven", marker="*", color=DRIVEN)
        if wrong:
            places = np.array(wrong)
            axes.plot(*places.T, "o", mfc="none", mec=MODEL, mew=2.2, ms=22, label="wrong here")
            axes.plot(*places.T, "x", color=MODEL, ms=7)
        axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
        axes.set_aspect("equal", adjustable="datalim")
        axes.margins(0.08)
        figure.legend(loc="outside lower center", ncols=5)
        figure.canvas.draw()
    return figure


def plate_words(plate: Plate) -> str:
    """Say in a line what plate it is: "240 × 190 × 3 mm, free"."""
    size = " × ".join(f"{1e3 * side:.4g}" for side in (plate.length_x, plate.length_y, plate.thickness))
    counted = (("hole", plate.hole), ("thickness zone", plate.zone), ("support", plate.support))
    return ", ".join(
        [
            f"{size} mm" + ("" if plate.outline is None else f" over all ({plate.outline.kind})"),
            *(f"{len(items)} {name}{'s' * (len(items) > 1)}" for name, items in counted if items),
            *([] if plate.support else [plate.boundary]),
            *(["curved"] if plate.curvature else []),
        ]
    )


def transducer_rows(experiment: Experiment) -> list[tuple[str, str]]:
    """Say what drives and senses besides patches, and where."""
    rows = [("drive", f"{d.id}: {d.kind} at {d.point[0]:g}, {d.point[1]:g} m, {d.side}") for d in experiment.drive]
    for sensor in experiment.sensor:
        places = sensor.places(experiment.plate)
        where = f"{places[0][0]:g}, {places[0][1]:g} m" if len(places) == 1 else f"{len(places)} points"
        loads = f", {1e3 * sensor.mass:g} g" if sensor.mass else ""
        rows.append(("sensor", f"{sensor.id}: {sensor.kind} at {where}, {sensor.side}{loads}"))
    return rows


def _along(curves: Sequence[Curve]) -> Real:
    return np.vstack([curve.at(np.linspace(0.0, 1.0, 49)) for curve in curves])


def _named(axes: Axes, named: Sequence[tuple[str, Point]], label: str, *, marker: str, color: str) -> None:
    """Mark points and print their names beside them."""
    if not named:
        return
    few, above = len(named) <= POINTS_IN_SMALL_PRINT, marker == "*"  # a point may be driven and measured
    size = (13 if above else 5) if few else 3
    axes.plot(*np.array([place for _, place in named]).T, marker, color=color, ms=size, ls="", label=label)
    offset, side = ((4, 5), "bottom") if above else ((4, -3), "top")
    for name, place in named:
        axes.annotate(
            name, place, offset, textcoords="offset points", va=side, color=color, fontsize=8.5 if few else 5
        )


def _lines(axes: Axes, curves: Sequence[Curve], label: str, **look: Any) -> None:
    for number, curve in enumerate(curves):
        axes.plot(*_along([curve]).T, label=None if number else label, solid_capstyle="butt", **look)


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
