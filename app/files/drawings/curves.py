"""Curves of a DXF drawing: lines, arcs, circles, ellipses, polylines with bulges, and splines.

Curves of an SVG drawing: paths and the basic shapes, y counted upward from the lower edge of the page.
"""

import re
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


SVG_METRES = {"mm": 1e-3, "cm": 1e-2, "in": 0.0254, "pt": 0.0254 / 72.0, "pc": 0.0254 / 6.0, "px": 0.0254 / 96.0}
"""Metres in a unit of the page's width; a px is 1/96 in (CSS Values and Units, level 3, section 6.2)."""
REFUSED = {
    "<!DOCTYPE": "a document type, which may name other files",
    "<!ENTITY": "an entity, which may name other files",
    "<use": "a clone (use), which may hold others without end; unlink it",
    "<image": "an image (image), which outlines nothing; remove it",
    "<symbol": "a symbol (symbol), which is drawn as its clones only; remove it",
}


def svg_curves(path: Path) -> tuple[list[Curve], float | None]:
    """Curves in the page's user unit, and how many metres that is; None where the page has no size.

    Raises
    ------
    ImportError
        Where svgelements is not installed.
    ValueError
        For what is no SVG, and for what one must not hold.
    """
    from svgelements import svgelements

    text = path.read_text(encoding="utf-8", errors="strict")
    plain = re.sub(r"<\s*(?:\w+:)?(?=\w)", "<", text)
    for mark, what in REFUSED.items():
        if mark.lower() in plain.lower():
            raise ValueError(f"holds {what}")
    try:
        drawing = svgelements.SVG.parse(str(path), reify=False, on_error="raise")
        page = svgelements.Matrix(drawing.viewbox_transform or "")
        page.inverse()
        shapes = [element for element in drawing.elements() if isinstance(element, svgelements.Shape)]
        bottom = _bottom(drawing)
        curves = [
            curve
            for shape in shapes
            if shape.values.get("visibility") not in ("hidden", "collapse")
            for segment in shape.segments(transformed=False)
            for curve in _svg_curves(segment * (shape.transform * page), bottom)
        ]
    except ValueError:
        raise
    except Exception as error:  # a damaged drawing leads the library into whatever there is
        raise ValueError(f"no SVG drawing that can be read ({error})") from error
    return curves, _unit(drawing)


def _size(drawing: Any, name: str) -> tuple[float, str] | None:
    """Width or height of the page, number and unit ("" without one); None where it is not given as a length."""
    text = str(drawing.values.get("attributes", {}).get(name, ""))
    size = re.fullmatch(r"\s*\+?([0-9.]+(?:[eE][+-]?[0-9]+)?)\s*(mm|cm|in|pt|pc|px|)\s*", text)
    return None if size is None else (float(size[1]), size[2])


def _unit(drawing: Any) -> float | None:
    """Metres in a user unit, from the size of the page and of what it shows; None where it has none.

    A page without a viewBox shows px. One in px is as good as one without a size: every program that writes it
    takes another number of them for an inch.
    """
    scales = []
    for name in ("width", "height"):
        size, shown = _size(drawing, name), getattr(drawing.viewbox, name, None)
        if size is None or size[1] in ("", "px"):
            continue
        if drawing.viewbox is None:
            return SVG_METRES["px"]
        if shown:
            scales.append(size[0] * SVG_METRES[size[1]] / float(shown))
    if not scales:
        return None
    fit = str(drawing.values.get("attributes", {}).get("preserveAspectRatio", ""))
    if fit.strip() == "none" and max(scales) > (1.0 + 1e-6) * min(scales):
        raise ValueError(
            "is stretched to its page (preserveAspectRatio none); give page and viewBox the same proportions"
        )
    return min(scales)


def _bottom(drawing: Any) -> float:
    """Lower edge of the page, user units; 0 where its height is unknown."""
    box, size = drawing.viewbox, _size(drawing, "height")
    if box is not None:
        return float(box.y + box.height) if box.height else 0.0
    return 0.0 if size is None else size[0] * SVG_METRES[size[1] or "px"] / SVG_METRES["px"]


def _svg_curves(piece: Any, bottom: float) -> list[Curve]:
    """Return what one segment of a path draws, seen with y upward."""
    kind = type(piece).__name__
    if kind == "Move":
        return []
    ends = [piece.start, piece.end]
    if kind in ("Line", "Close"):
        if piece.start is None or piece.end is None or piece.start == piece.end:
            return []
        begin, end = (_svg_point(point, bottom) for point in ends)
        return [Segment(begin, end)]
    if kind == "CubicBezier":
        one, two, three, four = (
            _svg_point(point, bottom) for point in (piece.start, piece.control1, piece.control2, piece.end)
        )
        return [Cubic((one, two, three, four))]
    if kind == "QuadraticBezier":
        a, b, c = (np.asarray(_svg_point(point, bottom)) for point in (piece.start, piece.control, piece.end))
        p, q, r, s = ((float(x), float(y)) for x, y in (a, (a + 2 * b) / 3, (c + 2 * b) / 3, c))
        return [Cubic((p, q, r, s))]
    if kind == "Arc":
        return list(quarters(_arc(piece, bottom)))
    raise ValueError(f"holds a {kind}, which is not read")


def _arc(piece: Any, bottom: float) -> Arc:
    """Part of an ellipse, from two conjugate half-diameters, which is what a transform makes of semi-axes.

    c + a cos t + b sin t with A = (a, b) = U S V' is an ellipse of semi-axes S along the columns of U.
    """
    center, begin, *ends = (
        np.asarray(_svg_point(point, bottom)) for point in (piece.center, piece.start, piece.prx, piece.pry)
    )
    across = np.stack(ends, axis=1) - center[:, None]
    left, radii, right = np.linalg.svd(across)
    cosine, sine = np.linalg.solve(across, begin - center)
    # the library turns the sweep where a transform mirrors, and counts it with y downward
    sweep = -float(piece.sweep) * float(np.sign(np.linalg.det(across)))
    flip = float(np.sign(np.linalg.det(left) * np.linalg.det(right)))
    ahead = np.arctan2(np.sign(np.linalg.det(right)) * right[1, 0], right[0, 0])
    start = float(np.arctan2(sine, cosine) + ahead)
    rotation = float(np.arctan2(left[1, 0], left[0, 0]))
    middle, axes = (float(center[0]), float(center[1])), (float(radii[0]), float(radii[1]))
    return Arc(middle, axes, rotation, flip * start, flip * sweep)


def _svg_point(place: Any, bottom: float) -> tuple[float, float]:
    return float(place.x), bottom - float(place.y)
