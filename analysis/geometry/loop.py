"""Closed chains of curves: area, centroid, what lies inside, how far away a point is."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import NDArray

from analysis.geometry.curves import Arc, Cubic, Curve, Segment, turning

Real = NDArray[np.float64]

CLOSES_WITHIN = 1e-9
"""Largest gap between the end of a curve and the start of the next, m."""
CHORD = np.deg2rad(3.0)
"""Turn of a curve that one side of its polygon stands for."""


@dataclass(frozen=True)
class Loop:
    """A closed chain of curves, counter-clockwise; ValueError where it is open.

    A loop given clockwise is turned round.
    """

    curves: tuple[Curve, ...]

    def __post_init__(self) -> None:
        if not self.curves:
            raise ValueError("a loop needs at least one curve")
        for number, (one, next_one) in enumerate(
            zip(self.curves, (*self.curves[1:], self.curves[0]), strict=True)
        ):
            end, start = one.at(1.0), next_one.at(0.0)
            gap = float(np.hypot(*(start - end)))
            if not gap <= CLOSES_WITHIN:
                raise ValueError(
                    f"open outline: curve {number + 1} ends at ({end[0]:.6g}, {end[1]:.6g}) m, the next one begins "
                    f"{gap:.3g} m away at ({start[0]:.6g}, {start[1]:.6g}) m"
                )
        if self._integral(_area) < 0.0:
            turned = tuple(curve.part(1.0, 0.0) for curve in reversed(self.curves))
            object.__setattr__(self, "curves", turned)

    def _integral(self, form: Callable[[Real, Real], Real]) -> float:
        """Sum over the curves of the integral of form(points, derivatives) over t."""
        nodes, weights = leggauss(24)
        t, total = 0.5 * (nodes + 1.0), 0.0
        for curve in self.curves:
            pieces = max(1, int(np.ceil(turning(curve))))
            for k in range(pieces):
                part = curve.part(k / pieces, (k + 1) / pieces)
                total += float(0.5 * weights @ form(part.at(t), part.derivative(t)))
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
    def polygon(self) -> Real:
        """Points (K, 2) along the loop, ends of curves among them, m."""
        points = []
        for curve in self.curves:
            pieces = max(1, int(np.ceil(turning(curve) / CHORD)))
            points.append(curve.at(np.arange(pieces) / pieces))
        return np.vstack(points)

    @property
    def bounds(self) -> tuple[Real, Real]:
        """Lower left and upper right corner of the bounding box, (2,) each, m."""
        return self.polygon.min(axis=0), self.polygon.max(axis=0)

    def contains(self, points: Real) -> NDArray[np.bool_]:
        """Which of the points (K, 2) lie inside the loop's polygon, by the crossing rule."""
        x, y = np.asarray(points, float).T[..., None]
        start = self.polygon
        end = np.roll(start, -1, axis=0)
        rises = (start[:, 1] > y) != (end[:, 1] > y)
        slope = np.where(rises, end[:, 1] - start[:, 1], 1.0)
        crossing = start[:, 0] + (y - start[:, 1]) * (end[:, 0] - start[:, 0]) / slope
        return np.asarray((rises & (x < crossing)).sum(axis=-1) % 2 == 1)

    def distance(self, points: Real) -> Real:
        """Distance of the points (K, 2) from the loop's polygon, (K,), m."""
        start = self.polygon
        step = np.roll(start, -1, axis=0) - start
        away = np.asarray(points, float)[:, None] - start
        length = np.maximum((step**2).sum(axis=1), 1e-30)
        t = np.clip((away * step).sum(axis=2) / length, 0.0, 1.0)
        return np.asarray(np.sqrt(((away - t[..., None] * step) ** 2).sum(axis=2)).min(axis=1))

    def moved(self, angle: float, shift: tuple[float, float]) -> "Loop":
        """Turn by `angle` rad about the origin, then shift, m."""
        c, s = np.cos(angle), np.sin(angle)

        def there(point: tuple[float, float]) -> tuple[float, float]:
            x, y = point
            return float(c * x - s * y + shift[0]), float(s * x + c * y + shift[1])

        def carried(curve: Curve) -> Curve:
            if isinstance(curve, Segment):
                return Segment(there(curve.start), there(curve.end))
            if isinstance(curve, Arc):
                return Arc(there(curve.center), curve.radii, curve.rotation + angle, curve.start, curve.sweep)
            one, two, three, four = (there(point) for point in curve.control)
            return Cubic((one, two, three, four))

        return Loop(tuple(carried(curve) for curve in self.curves))


def _area(point: Real, derivative: Real) -> Real:
    return np.asarray(0.5 * (point[:, 0] * derivative[:, 1] - point[:, 1] * derivative[:, 0]))
