"""Curves of an SVG drawing: paths and the basic shapes, y counted upward from the lower edge of the page."""

import re
from pathlib import Path
from typing import Any

import numpy as np

from analysis.geometry.loop import Arc, Cubic, Curve, Segment
from app.files.drawings.dxf_curves import quarters

METRES = {"mm": 1e-3, "cm": 1e-2, "in": 0.0254, "pt": 0.0254 / 72.0, "pc": 0.0254 / 6.0, "px": 0.0254 / 96.0}
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
            for curve in _curves(segment * (shape.transform * page), bottom)
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
            return METRES["px"]
        if shown:
            scales.append(size[0] * METRES[size[1]] / float(shown))
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
    return 0.0 if size is None else size[0] * METRES[size[1] or "px"] / METRES["px"]


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
        return list(quarters(_arc(piece, bottom)))
    raise ValueError(f"holds a {kind}, which is not read")


def _arc(piece: Any, bottom: float) -> Arc:
    """Part of an ellipse, from two conjugate half-diameters, which is what a transform makes of semi-axes.

    c + a cos t + b sin t with A = (a, b) = U S V' is an ellipse of semi-axes S along the columns of U.
    """
    center, begin, *ends = (
        np.asarray(_point(point, bottom)) for point in (piece.center, piece.start, piece.prx, piece.pry)
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


def _point(place: Any, bottom: float) -> tuple[float, float]:
    return float(place.x), bottom - float(place.y)
