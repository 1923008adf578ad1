"""The common shapes as loops."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from analysis.geometry.loop import Arc, Cubic, Loop, Point, Segment


def rectangle(center: Point, size: tuple[float, float], angle: float = 0.0) -> Loop:
    """Rectangle as four segments.

    Parameters
    ----------
    center : (float, float)
        m.
    size : (float, float)
        Sides, m.
    angle : float
        Of the first side against x, rad.
    """
    a, b = 0.5 * size[0], 0.5 * size[1]
    return polygon([(-a, -b), (a, -b), (a, b), (-a, b)]).moved(angle, center)


def polygon(points: Sequence[Point]) -> Loop:
    """Polygon through at least three points, m."""
    if len(points) < 3:
        raise ValueError(f"a polygon of {len(points)} points encloses nothing; give at least 3")
    return Loop(tuple(Segment(a, b) for a, b in zip(points, (*points[1:], points[0]), strict=True)))


def ellipse(center: Point, radii: tuple[float, float], angle: float = 0.0) -> Loop:
    """Ellipse as four arcs.

    Parameters
    ----------
    center : (float, float)
        m.
    radii : (float, float)
        Semi-axes, m.
    angle : float
        Of the first semi-axis against x, rad.
    """
    quarter = 0.5 * np.pi
    return Loop(tuple(Arc(center, radii, angle, k * quarter, quarter) for k in range(4)))


def circle(center: Point, radius: float) -> Loop:
    """Circle about `center`, m; four arcs."""
    return ellipse(center, (radius, radius))


def closed_spline(points: ArrayLike) -> Loop:
    """Periodic cubic spline through points (K, 2), K at least 4, m, its parameter the length of the chords."""
    from scipy.interpolate import CubicSpline

    through = np.asarray(points, float)
    if through.ndim != 2 or through.shape[1] != 2 or len(through) < 4:
        raise ValueError(f"a closed spline needs at least 4 points of x and y; got {through.shape}")
    around = np.vstack([through, through[:1]])
    knots = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(around, axis=0).T))])
    if not (np.diff(knots) > 0.0).all():
        raise ValueError("a closed spline runs through the same point twice in a row")
    spline = CubicSpline(knots, around, bc_type="periodic")
    slopes = spline(knots, 1)
    spans = []
    for k, third in enumerate(np.diff(knots) / 3.0):
        control = (around[k], around[k] + third * slopes[k], around[k + 1] - third * slopes[k + 1], around[k + 1])
        one, two, three, four = ((float(x), float(y)) for x, y in control)
        spans.append(Cubic((one, two, three, four)))
    return Loop(tuple(spans))
