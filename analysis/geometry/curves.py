"""Plane curves over a parameter t in [0, 1]: segments, elliptic arcs and cubic Bezier curves.

A span of a cubic spline is a cubic Bezier curve, and so is every quadratic one: these three kinds hold all that
drawings are made of.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

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
