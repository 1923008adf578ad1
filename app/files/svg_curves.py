"""Curves of an SVG drawing: paths and the basic shapes, y counted upward from the lower edge of the page."""

import re
from pathlib import Path
from typing import Any

import numpy as np

from analysis.geometry.curves import Arc, Cubic, Curve, Segment
from app.files.dxf_curves import quarters

METRES = {"mm": 1e-3, "cm": 1e-2, "in": 0.0254, "pt": 0.0254 / 72.0, "pc": 0.0254 / 6.0, "px": 0.0254 / 96.0}
"""Metres in a unit of the page's width."""
REFUSED = {
    "<!DOCTYPE": "a document type, which may name other files",
    "<!ENTITY": "an entity, which may name other files",
    "<use": "a clone (use), which may hold others without end; unlink it",
    "<image": "an image (image), which outlines nothing; remove it",
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
        drawing = svgelements.SVG.parse(str(path), reify=True, on_error="raise")
        page = svgelements.Matrix(drawing.viewbox_transform or "")
        page.inverse()
        shapes = [element for element in drawing.elements() if isinstance(element, svgelements.Shape)]
        pieces = [segment for shape in shapes for segment in (svgelements.Path(shape) * page).reify()]
        box = drawing.viewbox
        bottom = float(box.y + box.height) if box is not None and box.height else 0.0
        curves = [curve for piece in pieces for curve in _curves(piece, bottom)]
    except ValueError:
        raise
    except Exception as error:  # a damaged drawing leads the library into whatever there is
        raise ValueError(f"no SVG drawing that can be read ({error})") from error
    return curves, _unit(drawing)


def _unit(drawing: Any) -> float | None:
    """Metres in a user unit, from the size of the page and of what it shows; None where it has none."""
    attributes = drawing.values.get("attributes", {})
    scales = []
    for name in ("width", "height"):
        size = re.fullmatch(r"\s*([0-9.eE+-]+)\s*(mm|cm|in|pt|pc)\s*", str(attributes.get(name, "")))
        shown = getattr(drawing.viewbox, name, None)
        if size and shown:
            scales.append(float(size[1]) * METRES[size[2]] / float(shown))
    return min(scales) if scales else None


def _curves(piece: Any, bottom: float) -> list[Curve]:
    """Return what one segment of a path draws, seen with y upward."""
    kind = type(piece).__name__
    if kind == "Move":
        return []
    ends = [piece.start, piece.end]
    if kind in ("Line", "Close"):
        if piece.start is None or piece.end is None or piece.start == piece.end:
            return []
        begin, end = (_point(point, bottom) for point in ends)
        return [Segment(begin, end)]
    if kind == "CubicBezier":
        one, two, three, four = (
            _point(point, bottom) for point in (piece.start, piece.control1, piece.control2, piece.end)
        )
        return [Cubic((one, two, three, four))]
    if kind == "QuadraticBezier":
        a, b, c = (np.asarray(_point(point, bottom)) for point in (piece.start, piece.control, piece.end))
        p, q, r, s = ((float(x), float(y)) for x, y in (a, (a + 2 * b) / 3, (c + 2 * b) / 3, c))
        return [Cubic((p, q, r, s))]
    if kind == "Arc":
        radii = float(piece.rx), float(piece.ry)
        rotation = -float(piece.get_rotation())
        start, sweep = -float(piece.get_start_t()), -float(piece.sweep)
        return list(quarters(Arc(_point(piece.center, bottom), radii, rotation, start, sweep)))
    raise ValueError(f"holds a {kind}, which is not read")


def _point(place: Any, bottom: float) -> tuple[float, float]:
    return float(place.x), bottom - float(place.y)
