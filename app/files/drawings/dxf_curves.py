"""Curves of a DXF drawing: lines, arcs, circles, ellipses, polylines with bulges, and splines."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from analysis.geometry.loop import Arc, Cubic, Curve, Point, Segment

METRES = {1: 0.0254, 2: 0.3048, 4: 1e-3, 5: 1e-2, 6: 1.0, 9: 2.54e-5, 10: 0.9144, 13: 1e-6, 14: 0.1}
"""Metres in a unit, by the file's ``$INSUNITS``: inch, foot, mm, cm, m, mil, yard, µm, dm."""
LEVEL_SLOPE = 1e-6
"""Largest slope against the drawing's plane of what counts as lying in it."""
TILTED = "that does not lie in the plane of x and y; flatten the drawing"
SPLINE_PARTS = 8
"""Cubic curves for each span of a spline that is not cubic, or rational."""
WITHOUT_AREA = {
    "TEXT",
    "MTEXT",
    "DIMENSION",
    "POINT",
    "LEADER",
    "MULTILEADER",
    "HATCH",
    "ATTDEF",
    "ATTRIB",
    "XLINE",
}
"""Entities that outline nothing."""


def dxf_curves(path: Path, layer: str | None = None) -> tuple[list[Curve], float | None]:
    """Curves in the drawing's own unit, and how many metres that is; None where the file does not say.

    Parameters
    ----------
    layer : str, optional
        Only what stands on this layer, upper and lower case being the same; unless given, what the drawing shows.

    Raises
    ------
    ImportError
        Where ezdxf is not installed.
    ValueError
        For what is no DXF, a unit that no plate is drawn in, a layer without entities, and for entities that
        cannot be read or are not in the plane.
    """
    from ezdxf.filemanagement import readfile

    try:
        drawing = readfile(path)
        curves = [curve for entity in _chosen(drawing, layer) for curve in _curves(entity)]
        unit = int(drawing.header.get("$INSUNITS", 0))
    except UnicodeError as error:
        raise ValueError("no DXF drawing: its text cannot be decoded") from error
    except ValueError:
        raise
    except Exception as error:  # a damaged drawing leads the library into whatever there is
        raise ValueError(f"no DXF drawing that can be read ({error})") from error
    if unit and unit not in METRES:
        raise ValueError(f"its unit ($INSUNITS {unit}) is not that of a plate; allowed inch, foot, mm, cm or m")
    return curves, METRES.get(unit)


def _chosen(drawing: Any, layer: str | None) -> list[Any]:
    """Entities on a layer; unless one is named, those that are visible: construction lines are often hidden."""
    entities = list(drawing.modelspace())
    if layer is None:
        hidden = {one.dxf.name.casefold() for one in drawing.layers if one.is_frozen() or one.is_off()}
        return [e for e in entities if e.dxf.layer.casefold() not in hidden and not e.dxf.get("invisible", 0)]
    found = [e for e in entities if e.dxf.layer.casefold() == layer.casefold()]
    if not found:
        there = ", ".join(sorted({repr(e.dxf.layer) for e in entities})) or "none"
        raise ValueError(f"nothing stands on layer {layer!r}; the drawing has {there}")
    return found


def _curves(entity: Any) -> Iterator[Curve]:
    kind = entity.dxftype()
    if kind in WITHOUT_AREA:
        return
    flipped = kind not in ("LINE", "SPLINE") and _seen_from_below(entity)
    if kind == "LINE":
        yield Segment(*_flat([entity.dxf.start, entity.dxf.end], kind))
    elif kind in ("ARC", "CIRCLE"):
        begin, end = (0.0, 360.0) if kind == "CIRCLE" else (entity.dxf.start_angle, entity.dxf.end_angle)
        sweep = np.deg2rad((end - begin) % 360.0 or 360.0)
        radius = float(entity.dxf.radius)
        center = _point(entity.dxf.center)
        for arc in quarters(Arc(center, (radius, radius), 0.0, float(np.deg2rad(begin)), float(sweep))):
            yield _mirrored(arc) if flipped else arc
    elif kind == "ELLIPSE":
        yield from _ellipse(entity, flipped)
    elif kind == "LWPOLYLINE":
        rows = [(float(x), float(y), float(b)) for x, y, b in entity.get_points("xyb")]
        yield from (_mirrored(c) if flipped else c for c in _polyline(rows, bool(entity.closed)))
    elif kind == "POLYLINE" and entity.is_2d_polyline:
        rows = [(float(v.dxf.location.x), float(v.dxf.location.y), float(v.dxf.bulge)) for v in entity.vertices]
        yield from (_mirrored(c) if flipped else c for c in _polyline(rows, bool(entity.is_closed)))
    elif kind == "SPLINE":
        yield from _spline(entity.construction_tool())
    else:
        raise ValueError(
            f"holds a {kind}, which is not read; break blocks up, and keep lines, arcs, circles, ellipses, "
            "polylines and splines"
        )


def _seen_from_below(entity: Any) -> bool:
    """Whether an entity is drawn on the plane seen from below; ValueError for one on another plane."""
    x, y, z = entity.dxf.get("extrusion", (0.0, 0.0, 1.0))
    if np.hypot(x, y) > LEVEL_SLOPE * abs(z):
        raise ValueError(f"holds a {entity.dxftype()} {TILTED}")
    return bool(z < 0.0)


def _flat(places: Sequence[Any], kind: str) -> list[Point]:
    """Points of an entity in the plane; ValueError where they differ in height."""
    high = [float(place[2]) for place in places]
    extent = float(np.ptp(np.array([_point(place) for place in places]), axis=0).max())
    if max(high) - min(high) > LEVEL_SLOPE * extent:
        raise ValueError(f"holds a {kind} {TILTED}")
    return [_point(place) for place in places]


def _point(place: Any) -> Point:
    return float(place[0]), float(place[1])


def _mirrored(curve: Curve) -> Curve:
    """Return a curve drawn on a plane seen from below: x runs the other way."""
    if isinstance(curve, Segment):
        return Segment((-curve.start[0], curve.start[1]), (-curve.end[0], curve.end[1]))
    if isinstance(curve, Arc):
        return Arc(
            (-curve.center[0], curve.center[1]), curve.radii, np.pi - curve.rotation, -curve.start, -curve.sweep
        )
    one, two, three, four = ((-x, y) for x, y in curve.control)
    return Cubic((one, two, three, four))


def quarters(arc: Arc) -> list[Arc]:
    """Cut an arc into parts of at most a quarter of the ellipse."""
    count = max(1, int(np.ceil(abs(arc.sweep) / (0.5 * np.pi) - 1e-9)))
    return [arc.part(k / count, (k + 1) / count) for k in range(count)]


def _ellipse(entity: Any, flipped: bool) -> Iterator[Curve]:
    major = np.array(_point(entity.dxf.major_axis))
    radii = float(np.hypot(*major)), float(np.hypot(*major) * entity.dxf.ratio)
    begin, end = float(entity.dxf.start_param), float(entity.dxf.end_param)
    sweep = (end - begin) % (2.0 * np.pi) or 2.0 * np.pi
    if abs(end - begin - 2.0 * np.pi) < 1e-9:
        sweep = 2.0 * np.pi
    sign = -1.0 if flipped else 1.0  # seen from below, the second axis points the other way
    rotation = float(np.arctan2(major[1], major[0]))
    yield from quarters(Arc(_point(entity.dxf.center), radii, rotation, sign * begin, sign * sweep))


def _polyline(rows: list[tuple[float, float, float]], closed: bool) -> Iterator[Curve]:
    ends = [*rows[1:], rows[0]] if closed else rows[1:]
    for (x, y, bulge), (u, v, _) in zip(rows, ends, strict=False):
        if (x, y) == (u, v):
            continue
        if bulge == 0.0:
            yield Segment((x, y), (u, v))
            continue
        # The bulge is the tangent of a quarter of the angle swept.
        sweep, chord = 4.0 * np.arctan(bulge), complex(u - x, v - y)
        center = complex(x, y) + 0.5 * chord * (1.0 + 1j / np.tan(0.5 * sweep))
        radius = abs(complex(x, y) - center)
        begin = float(np.angle(complex(x, y) - center))
        yield from quarters(Arc((center.real, center.imag), (radius, radius), 0.0, begin, float(sweep)))


def _spline(spline: Any) -> Iterator[Curve]:
    """Cubic curves with the spline's own points and slopes: exact where it is cubic and not rational."""
    _flat(spline.control_points, "SPLINE")
    # periodic splines have knots before their first point and after their last one
    every, degree = np.array(spline.knots(), float), spline.degree
    knots = np.unique(every[degree : len(every) - degree])
    parts = 1 if spline.degree == 3 and not spline.is_rational else SPLINE_PARTS
    for low, high in pairwise(knots):
        # A knot belongs to two spans: a cubic's slope is the same in both unless the knot is a corner.
        inside = np.linspace(low, high, parts + 1)
        reach = 1e-9 * (high - low)
        inside[0], inside[-1] = low + reach, high - reach
        found = [[_point(value) for value in values] for values in spline.derivatives(inside.tolist(), 1)]
        third = (high - low) / parts / 3.0
        for (a, u), (d, v) in pairwise(found):
            b = (a[0] + third * u[0], a[1] + third * u[1])
            c = (d[0] - third * v[0], d[1] - third * v[1])
            yield Cubic((a, b, c, d))
