"""Closed chains of curves: area, centroid, what lies inside, how far away a point is; loops from loose curves.

Plane curves over a parameter t in [0, 1]: segments, elliptic arcs and cubic Bezier curves. A span of a
cubic spline is a cubic Bezier curve, and so is every quadratic one: drawings are made of nothing else.
Rectangles, polygons, ellipses, circles and closed splines are loops of them.

What is wrong with a geometry, and where.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import ArrayLike, NDArray

from analysis.arrays import Real

Point = tuple[float, float]


@dataclass(frozen=True)
class Segment:
    """A straight line from `start` to `end`, m."""

    start: Point
    end: Point

    def at(self, t: ArrayLike) -> Real:
        """Points (..., 2) at parameters t (...)."""
        a, b = np.asarray(self.start), np.asarray(self.end)
        return np.asarray(a + np.asarray(t, float)[..., None] * (b - a))

    def derivative(self, t: ArrayLike) -> Real:
        """Return derivatives by t, (..., 2)."""
        step = np.asarray(self.end) - np.asarray(self.start)
        return np.broadcast_to(step, (*np.shape(t), 2)).copy()

    def part(self, first: float, last: float) -> "Segment":
        """Return the piece between two parameters; backwards where `last` is the smaller."""
        a, b = self.at([first, last])
        return Segment((float(a[0]), float(a[1])), (float(b[0]), float(b[1])))


@dataclass(frozen=True)
class Arc:
    """A part of an ellipse.

    Attributes
    ----------
    center : (float, float)
        m.
    radii : (float, float)
        Semi-axes, m; equal for a circle.
    rotation : float
        Of the first semi-axis against x, rad.
    start, sweep : float
        Eccentric angle at t = 0, and what is added to it until t = 1 (positive: counter-clockwise), rad.
    """

    center: Point
    radii: Point
    rotation: float
    start: float
    sweep: float

    @property
    def _axes(self) -> tuple[Real, Real]:
        c, s = np.cos(self.rotation), np.sin(self.rotation)
        return self.radii[0] * np.array([c, s]), self.radii[1] * np.array([-s, c])

    def at(self, t: ArrayLike) -> Real:
        """Points (..., 2) at parameters t (...)."""
        angle = self.start + self.sweep * np.asarray(t, float)[..., None]
        first, second = self._axes
        return np.asarray(np.asarray(self.center) + np.cos(angle) * first + np.sin(angle) * second)

    def derivative(self, t: ArrayLike) -> Real:
        """Return derivatives by t, (..., 2)."""
        angle = self.start + self.sweep * np.asarray(t, float)[..., None]
        first, second = self._axes
        return np.asarray(self.sweep * (np.cos(angle) * second - np.sin(angle) * first))

    def part(self, first: float, last: float) -> Self:
        """Return the piece between two parameters; backwards where `last` is the smaller."""
        return replace(self, start=self.start + self.sweep * first, sweep=self.sweep * (last - first))


@dataclass(frozen=True)
class Cubic:
    """A cubic Bezier curve.

    Attributes
    ----------
    control : four points
        m; the curve begins at the first and ends at the last.
    """

    control: tuple[Point, Point, Point, Point]

    def at(self, t: ArrayLike) -> Real:
        """Points (..., 2) at parameters t (...)."""
        t = np.asarray(t, float)[..., None]
        a, b, c, d = (np.asarray(point) for point in self.control)
        s = 1.0 - t
        return np.asarray(s**3 * a + 3.0 * s**2 * t * b + 3.0 * s * t**2 * c + t**3 * d)

    def derivative(self, t: ArrayLike) -> Real:
        """Return derivatives by t, (..., 2)."""
        t = np.asarray(t, float)[..., None]
        a, b, c, d = (np.asarray(point) for point in self.control)
        s = 1.0 - t
        return np.asarray(3.0 * (s**2 * (b - a) + 2.0 * s * t * (c - b) + t**2 * (d - c)))

    def part(self, first: float, last: float) -> "Cubic":
        """Return the piece between two parameters; backwards where `last` is the smaller."""
        (a, d), step = self.at([first, last]), (last - first) / 3.0
        slopes = self.derivative([first, last])
        points = (a, a + step * slopes[0], d - step * slopes[1], d)
        one, two, three, four = ((float(x), float(y)) for x, y in points)
        return Cubic((one, two, three, four))


Curve = Segment | Arc | Cubic


def moved(curve: Curve, angle: float, shift: Point, scale: float = 1.0) -> Curve:
    """Return a curve enlarged and turned about the origin, then shifted.

    Parameters
    ----------
    curve : Segment, Arc or Cubic
    angle : float
        rad, from x towards y.
    shift : (float, float)
        m.

    Returns
    -------
    Segment, Arc or Cubic
        Of the same kind.
    """
    c, s = scale * np.cos(angle), scale * np.sin(angle)

    def there(point: Point) -> Point:
        x, y = point
        return float(c * x - s * y + shift[0]), float(s * x + c * y + shift[1])

    if isinstance(curve, Segment):
        return Segment(there(curve.start), there(curve.end))
    if isinstance(curve, Arc):
        radii = (scale * curve.radii[0], scale * curve.radii[1])
        return Arc(there(curve.center), radii, curve.rotation + angle, curve.start, curve.sweep)
    one, two, three, four = (there(point) for point in curve.control)
    return Cubic((one, two, three, four))


def turning(curve: Curve, pieces: int = 16) -> float:
    """Angle through which a curve's tangent turns in all, rad, not below zero."""
    if isinstance(curve, Segment):
        return 0.0
    along = curve.derivative(np.linspace(0.0, 1.0, pieces + 1))
    angle = np.unwrap(np.arctan2(along[:, 1], along[:, 0]))
    return float(np.abs(np.diff(angle)).sum())


CLOSES_WITHIN = 1e-9
"""Largest gap between the end of a curve and the start of the next, m."""
CHORD = np.deg2rad(3.0)
"""Largest turn of a curve that one side of its polygon replaces."""
NODES, WEIGHTS = leggauss(24)
"""Of the integrals along a curve."""
PAIRS_AT_ONCE = 1_000_000
"""Pairs of points and sides looked at together."""


@dataclass(frozen=True)
class Nearest:
    """The points of a loop nearest to given ones.

    Attributes
    ----------
    curve : (K,) ndarray of int
        Which curve of the loop they lie on, from 0.
    t : (K,) ndarray
        Where on it.
    points : (K, 2) ndarray
        m.
    distance : (K,) ndarray
        m.
    """

    curve: NDArray[np.intp]
    t: Real
    points: Real
    distance: Real


@dataclass(frozen=True)
class Loop:
    """A closed chain of curves, counter-clockwise; GeometryError where it is open.

    A loop given clockwise is reversed and `turned` set; curve k of n given is then curve n - 1 - k.
    """

    curves: tuple[Curve, ...]
    turned: bool = field(default=False, init=False, compare=False)

    def __post_init__(self) -> None:
        if not self.curves:
            raise ValueError("a loop needs at least one curve")
        for number, (one, next_one) in enumerate(
            zip(self.curves, (*self.curves[1:], self.curves[0]), strict=True)
        ):
            end, start = one.at(1.0), next_one.at(0.0)
            gap = float(np.hypot(*(start - end)))
            if not gap <= CLOSES_WITHIN:
                raise GeometryError(
                    f"open outline: curve {number + 1} ends at ({end[0]:.6g}, {end[1]:.6g}) m, the next one "
                    f"begins {gap:.3g} m away at ({start[0]:.6g}, {start[1]:.6g}) m; close the gap",
                    end,
                    start,
                )
        if self._integral(_area) < 0.0:
            turned = tuple(curve.part(1.0, 0.0) for curve in reversed(self.curves))
            object.__setattr__(self, "curves", turned)
            object.__setattr__(self, "turned", True)

    def _integral(self, form: Callable[[Real, Real], Real]) -> float:
        """Sum over the curves of the integral of form(points, derivatives) over t."""
        t, total = 0.5 * (NODES + 1.0), 0.0
        for curve in self.curves:
            pieces = max(1, int(np.ceil(turning(curve))))
            for k in range(pieces):
                part = curve.part(k / pieces, (k + 1) / pieces)
                total += float(0.5 * WEIGHTS @ form(part.at(t), part.derivative(t)))
        return total

    @cached_property
    def area(self) -> float:
        """Area inside, m2 (Green's theorem)."""
        return self._integral(_area)

    @cached_property
    def centroid(self) -> tuple[float, float]:
        """Centre of the area inside, m."""
        x = self._integral(lambda p, d: 0.5 * p[:, 0] ** 2 * d[:, 1]) / self.area
        y = self._integral(lambda p, d: -0.5 * p[:, 1] ** 2 * d[:, 0]) / self.area
        return x, y

    @cached_property
    def perimeter(self) -> float:
        """Length, m."""
        return self._integral(lambda p, d: np.hypot(d[:, 0], d[:, 1]))

    @cached_property
    def _pieces(self) -> tuple[Real, NDArray[np.intp], Real]:
        """Points (K, 2) along the loop, and the curve (K,) and parameters (K, 2) of the side after each."""
        points, curves, spans = [], [], []
        for number, curve in enumerate(self.curves):
            pieces = max(1, int(np.ceil(turning(curve) / CHORD)))
            ends = np.arange(pieces + 1) / pieces
            points.append(curve.at(ends[:-1]))
            curves.append(np.full(pieces, number))
            spans.append(np.stack([ends[:-1], ends[1:]], axis=1))
        return np.vstack(points), np.concatenate(curves), np.vstack(spans)

    @property
    def polygon(self) -> Real:
        """Points (K, 2) along the loop, ends of curves among them, m."""
        return self._pieces[0]

    def over_sides(self, side: NDArray[np.intp], share: Real) -> tuple[Real, Real]:
        """Points (K, 2) and derivatives on the curves over sides of `polygon`, at shares 0 to 1 of each side."""
        _, curves, spans = self._pieces
        return _at(self.curves, curves[side], spans[side, 0] + share * (spans[side, 1] - spans[side, 0]))

    @cached_property
    def bounds(self) -> tuple[Real, Real]:
        """Lower left and upper right corner of the bounding box, (2,) each, m."""
        bent = [curve for curve in self.curves if not isinstance(curve, Segment)]
        points = np.vstack([self.polygon, *(_extremes(curve) for curve in bent)])
        return points.min(axis=0), points.max(axis=0)

    def contains(self, points: Real, within: float = 0.0) -> NDArray[np.bool_]:
        """Which of the points (K, 2) lie inside the loop, or at most `within` m away from it."""
        points = np.asarray(points, float).reshape(-1, 2)
        inside = self._crossed(points)
        start = self.polygon
        sides = np.hypot(*(np.roll(start, -1, axis=0) - start).T)
        bent = np.array([not isinstance(curve, Segment) for curve in self.curves])[self._pieces[1]]
        between = 0.01 * float(np.max(sides, where=bent, initial=0.0))  # no curve leaves its chords farther
        if within <= 0.0 and between <= 0.0:
            return inside
        near = np.flatnonzero(self.distance(points) <= between + within)
        found = self.nearest(points[near])
        along = _at(self.curves, found.curve, found.t)[1]
        away = points[near] - found.points
        left = along[:, 0] * away[:, 1] - along[:, 1] * away[:, 0] > 0.0
        inner = (found.t > 0.0) & (found.t < 1.0)  # at a corner the polygon is exact
        inside[near] = np.where(inner, left, inside[near]) | (found.distance <= within)
        return inside

    def _crossed(self, points: Real) -> NDArray[np.bool_]:
        """Which of the points (K, 2) lie inside the polygon, by the crossing rule."""
        start = self.polygon
        end = np.roll(start, -1, axis=0)
        inside = np.zeros(len(points), bool)
        for rows in self._rows(len(points)):
            x, y = points[rows].T[..., None]
            rises = (start[:, 1] > y) != (end[:, 1] > y)
            slope = np.where(rises, end[:, 1] - start[:, 1], 1.0)
            crossing = start[:, 0] + (y - start[:, 1]) * (end[:, 0] - start[:, 0]) / slope
            inside[rows] = (rises & (x < crossing)).sum(axis=-1) % 2 == 1
        return inside

    def distance(self, points: Real) -> Real:
        """Distance of the points (K, 2) from the loop's polygon, (K,), m."""
        return self._on_polygon(np.asarray(points, float).reshape(-1, 2))[2]

    def nearest(self, points: Real) -> Nearest:
        """Return the points of the loop nearest to the points (K, 2), on the curves themselves."""
        points = np.asarray(points, float).reshape(-1, 2)
        side, share, _ = self._on_polygon(points)
        _, curves, spans = self._pieces
        curve = curves[side]
        t = spans[side, 0] + share * (spans[side, 1] - spans[side, 0])
        at, along = _at(self.curves, curve, t)
        distance = np.hypot(*(points - at).T)
        for _ in range(8):  # Newton's step, never kept where it leads away
            away, square = points - at, np.maximum((along**2).sum(axis=1), 1e-30)
            bend = (_at(self.curves, curve, t + 1e-5)[1] - _at(self.curves, curve, t - 1e-5)[1]) / 2e-5
            step = (away * along).sum(axis=1) / np.maximum(square - (away * bend).sum(axis=1), 0.1 * square)
            tried = np.clip(t + step, 0.0, 1.0)
            there, slope = _at(self.curves, curve, tried)
            far = np.hypot(*(points - there).T)
            better = far < distance
            t, distance = np.where(better, tried, t), np.where(better, far, distance)
            at, along = np.where(better[:, None], there, at), np.where(better[:, None], slope, along)
        return Nearest(curve, t, at, distance)

    def _on_polygon(self, points: Real) -> tuple[NDArray[np.intp], Real, Real]:
        """Side of the polygon nearest to each point, where on it, from 0 to 1, and how far away, (K,) each."""
        start = self.polygon
        step = np.roll(start, -1, axis=0) - start
        length = np.maximum((step**2).sum(axis=1), 1e-30)
        side, share, far = np.zeros(len(points), np.intp), np.zeros(len(points)), np.zeros(len(points))
        for rows in self._rows(len(points)):
            away = points[rows, None] - start
            t = np.clip((away * step).sum(axis=2) / length, 0.0, 1.0)
            square = ((away - t[..., None] * step) ** 2).sum(axis=2)
            best = square.argmin(axis=1)
            pick = np.arange(len(best)), best
            side[rows], share[rows], far[rows] = best, t[pick], np.sqrt(square[pick])
        return side, share, far

    def _rows(self, count: int) -> Iterator[slice]:
        """Slices of `count` points, few enough to be held against all sides at once."""
        step = max(1, PAIRS_AT_ONCE // len(self.polygon))
        return (slice(first, first + step) for first in range(0, count, step))

    def moved(self, angle: float, shift: Point) -> "Loop":
        """Turn by `angle` rad about the origin, then shift, m."""
        return Loop(tuple(moved(curve, angle, shift) for curve in self.curves))


def _area(point: Real, derivative: Real) -> Real:
    return np.asarray(0.5 * (point[:, 0] * derivative[:, 1] - point[:, 1] * derivative[:, 0]))


def _at(curves: tuple[Curve, ...], number: NDArray[np.intp], t: Real) -> tuple[Real, Real]:
    """Points and derivatives (K, 2) at parameters (K,) of curves of these numbers (K,)."""
    points, slopes = np.zeros((len(t), 2)), np.zeros((len(t), 2))
    for one in np.unique(number):
        here = number == one
        points[here], slopes[here] = curves[one].at(t[here]), curves[one].derivative(t[here])
    return points, slopes


def _extremes(curve: Curve) -> Real:
    """Points along a bent curve, those among them where it runs along an axis."""
    from scipy.optimize import brentq

    fine = np.linspace(0.0, 1.0, 129)
    slope = curve.derivative(fine)
    found = [curve.at(fine)]
    for axis in (0, 1):
        for k in np.flatnonzero(slope[:-1, axis] * slope[1:, axis] < 0.0):
            low, high = float(fine[k]), float(fine[k + 1])
            zero = brentq(lambda at, axis=axis: float(curve.derivative(at)[axis]), low, high, xtol=1e-15)
            found.append(curve.at([zero]))
    return np.vstack(found)


def closed_loops(curves: Sequence[Curve], tolerance: float) -> tuple[Loop, ...]:
    """Chain curves whose ends meet into closed loops, the largest first.

    Curves no longer than the tolerance are left out; of the others, ends that meet within it are made to coincide,
    each curve being turned and stretched as a whole.

    Parameters
    ----------
    tolerance : float
        Largest gap that is closed, m.

    Raises
    ------
    GeometryError
        Where a chain is open, or more than two ends meet.
    """
    pieces = [part for curve in curves for part in _open_parts(curve, tolerance)]
    if not pieces:
        return ()
    ends = np.array([curve.at([0.0, 1.0]) for curve in pieces]).reshape(-1, 2)
    partner = _partners(ends, tolerance)
    left, loops = set(range(len(pieces))), []
    while left:
        number = min(left)
        chain, end = [], 2 * number
        while end // 2 in left:
            left.discard(end // 2)
            chain.append(pieces[end // 2] if end % 2 == 0 else pieces[end // 2].part(1.0, 0.0))
            end = partner[end ^ 1]  # from the other end of this curve to the curve that goes on there
        loops.append(Loop(tuple(_closed(chain))))
    return tuple(sorted(loops, key=lambda loop: -loop.area))


def _open_parts(curve: Curve, tolerance: float) -> list[Curve]:
    """Return nothing of a curve that is too short, both halves of one that comes back, else the curve itself."""
    along = curve.at(np.linspace(0.0, 1.0, 33))
    if np.hypot(*(along - along[0]).T).max() <= tolerance:
        return []
    whole = np.hypot(*np.diff(along, axis=0).T).sum()
    if not isinstance(curve, Segment) and np.hypot(*(along[-1] - along[0])) < 0.05 * whole:
        return [curve.part(0.0, 0.5), curve.part(0.5, 1.0)]
    return [curve]


def _partners(ends: Real, tolerance: float) -> list[int]:
    """Which end each of the ends (2n, 2) meets."""
    from scipy.spatial import cKDTree

    tree = cKDTree(ends)
    found = []
    for number in range(len(ends)):
        others = [int(other) for other in tree.query_ball_point(ends[number], tolerance) if other != number]
        place = ends[number]
        if not others:
            far = np.hypot(*(ends - place).T)
            far[number] = np.inf
            raise GeometryError(
                f"open outline: nothing goes on at {at(place)}; the nearest other end is {1e3 * far.min():.3g} mm "
                f"away, and gaps up to {1e3 * tolerance:g} mm are closed (tolerance)",
                place,
            )
        if len(others) > 1:
            raise GeometryError(
                f"{len(others) + 1} curves meet at {at(place)}, and no way round is clear; remove those that "
                "belong to no outline, and what was drawn twice",
                place,
            )
        found.append(others[0])
    return found


def _closed(chain: list[Curve]) -> list[Curve]:
    """Make every curve of a closed chain begin exactly where the one before it ends."""
    starts = [curve.at(0.0) for curve in chain]
    before = [chain[k - 1].at(1.0) for k in range(len(chain))]
    joints = [0.5 * (a + b) for a, b in zip(starts, before, strict=True)]
    return [
        _fitted(curve, joint, next_joint)
        for curve, joint, next_joint in zip(chain, joints, [*joints[1:], joints[0]], strict=True)
    ]


def _fitted(curve: Curve, start: Real, end: Real) -> Curve:
    """Turn, stretch and shift a curve so that it runs from `start` to `end`."""
    first, last = (complex(*point) for point in curve.at([0.0, 1.0]))
    begin, finish = complex(*start), complex(*end)
    ratio = (finish - begin) / (last - first)
    shift = begin - ratio * first
    return moved(curve, float(np.angle(ratio)), (shift.real, shift.imag), abs(ratio))


class GeometryError(ValueError):
    """A geometry that is impossible; the message contains the remedy.

    Attributes
    ----------
    places : tuple of (float, float)
        Where, m.
    """

    def __init__(self, message: str, *places: ArrayLike) -> None:
        super().__init__(message)
        self.places: tuple[tuple[float, float], ...] = tuple(
            (float(x), float(y)) for x, y in (np.asarray(place, float) for place in places)
        )


def at(place: ArrayLike) -> str:
    """Write a place in a message: "(0.12, 0.05) m"."""
    x, y = np.asarray(place, float)
    return f"({x:.6g}, {y:.6g}) m"


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
