"""Points where borders cross, touch or pass through each other's corners."""

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.geometry.curves import Curve, turning
from analysis.geometry.loop import Loop

MERGED_DISTANCE = 1e-7
"""Points closer than this are merged, m."""
CHORD = np.deg2rad(4.0)
"""Largest turn of a curve per side of its polyline, rad."""
TANGENT_SINE = 1e-4
"""Sine of the angle below which curves count as tangent, not crossing."""


def polyline(curve: Curve) -> tuple[Real, Real]:
    """Parameters (k,) and points (k, 2) along a curve."""
    t = np.linspace(0.0, 1.0, 1 + max(1, int(np.ceil(turning(curve) / CHORD))))
    return t, curve.at(t)


def cuts_of(borders: Sequence[Loop], extra: Real) -> list[list[list[float]]]:
    """Parameters at which every curve of every border is cut, ends included."""
    curves = [(b, c, curve) for b, loop in enumerate(borders) for c, curve in enumerate(loop.curves)]
    cuts = [[[0.0, 1.0] for _ in loop.curves] for loop in borders]
    lines = [polyline(curve) for _, _, curve in curves]
    ends = np.array([curve.at(0.0) for _, _, curve in curves])
    for (b, c, curve), line in zip(curves, lines, strict=True):
        cuts[b][c] += _passing(curve, line, np.vstack([ends, extra]))
    for (one, line), (other, line_2) in combinations(zip(curves, lines, strict=True), 2):
        for t, s in _crossings(one[2], line, other[2], line_2):
            cuts[one[0]][one[1]].append(t)
            cuts[other[0]][other[1]].append(s)
    return cuts


def _passing(curve: Curve, line: tuple[Real, Real], points: Real) -> list[float]:
    """Parameters at which a curve runs through some of the points, its ends left out."""
    t, along = line
    step = np.diff(along, axis=0)
    away = points[:, None] - along[:-1]
    length = np.maximum((step**2).sum(axis=1), 1e-30)
    share = np.clip((away * step).sum(axis=2) / length, 0.0, 1.0)
    distance = np.hypot(*np.moveaxis(away - share[..., None] * step, -1, 0))
    reach = 2.0 * CHORD * np.sqrt(length.max()) + MERGED_DISTANCE if len(t) > 2 else MERGED_DISTANCE
    found = []
    for k in np.flatnonzero(distance.min(axis=1) < reach):
        i = int(distance[k].argmin())
        place = float(t[i] + share[k, i] * (t[i + 1] - t[i]))
        for _ in range(12):
            slope, miss = curve.derivative(place), curve.at(place) - points[k]
            place = float(np.clip(place - slope @ miss / (slope @ slope), 0.0, 1.0))
        ends = np.array([points[k] - curve.at(0.0), points[k] - curve.at(1.0)])
        if (
            np.hypot(*(curve.at(place) - points[k])) < MERGED_DISTANCE
            and np.hypot(*ends.T).min() > MERGED_DISTANCE
        ):
            found.append(place)
    return found


def _crossings(
    one: Curve, line: tuple[Real, Real], other: Curve, line_2: tuple[Real, Real]
) -> list[tuple[float, float]]:
    """Parameters (t, s) at which two curves cross, common ends left out."""
    (t, p), (s, q) = line, line_2
    margin = 0.02 * (np.ptp(p, axis=0).max() + np.ptp(q, axis=0).max()) + MERGED_DISTANCE
    if (p.min(axis=0) > q.max(axis=0) + margin).any() or (q.min(axis=0) > p.max(axis=0) + margin).any():
        return []
    a, b = np.diff(p, axis=0)[:, None], np.diff(q, axis=0)[None]
    gap = q[None, :-1] - p[:-1, None]
    det = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    oblique = np.abs(det) > 1e-9 * np.hypot(*np.moveaxis(a, -1, 0)) * np.hypot(*np.moveaxis(b, -1, 0))
    safe = np.where(oblique, det, 1.0)
    x = (gap[..., 0] * b[..., 1] - gap[..., 1] * b[..., 0]) / safe
    y = (gap[..., 0] * a[..., 1] - gap[..., 1] * a[..., 0]) / safe
    near = oblique & (x > -0.05) & (x < 1.05) & (y > -0.05) & (y < 1.05)
    found: list[tuple[float, float]] = []
    for i, j in zip(*np.nonzero(near), strict=True):
        place = np.array([t[i] + x[i, j] * (t[i + 1] - t[i]), s[j] + y[i, j] * (s[j + 1] - s[j])])
        for _ in range(8):
            slopes = np.column_stack([one.derivative(place[0]), -other.derivative(place[1])])
            if abs(np.linalg.det(slopes)) < TANGENT_SINE * np.prod(np.hypot(*slopes)):
                break  # the curves coincide
            place = np.clip(place - np.linalg.solve(slopes, one.at(place[0]) - other.at(place[1])), 0.0, 1.0)
        else:
            meet = one.at(place[0])
            if np.hypot(*(meet - other.at(place[1]))) > MERGED_DISTANCE:
                continue
            if not any(np.hypot(*(meet - one.at(known))) < MERGED_DISTANCE for known, _ in found):
                found.append((float(place[0]), float(place[1])))
    return found


def inside(places: Real, start: Real, end: Real) -> NDArray[np.bool_]:
    """Which places lie within closed rings of sides: a ray crosses them an odd number of times.

    Parameters
    ----------
    places : (K, 2) ndarray, m
    start, end : (S, 2) ndarray, m
        Ends of the sides, of all rings.

    Returns
    -------
    (K,) ndarray of bool
    """
    x, y = places.T[..., None]
    rises = (start[:, 1] > y) != (end[:, 1] > y)
    slope = np.where(rises, end[:, 1] - start[:, 1], 1.0)
    crossing = start[:, 0] + (y - start[:, 1]) * (end[:, 0] - start[:, 0]) / slope
    return np.asarray((rises & (x < crossing)).sum(axis=1) % 2 == 1)
