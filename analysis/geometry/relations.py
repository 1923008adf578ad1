"""Relative position of closed loops: crossings, overlaps and gaps, each with its place."""

import numpy as np

from analysis.arrays import Mask, Real, Whole
from analysis.geometry.loop import PAIRS_AT_ONCE, Loop

TOUCH = 1e-6
"""What lies no farther apart than this touches, m."""
POINTS_OVER_CHORD = 17
"""Points along the curve over a chord that is held against another loop."""
PIECES_OF_LOOP = 128
"""Into how many pieces at least the way round a loop is cut to hold it against another."""


def self_crossing(loop: Loop) -> Real | None:
    """Where a loop crosses or touches itself, (2,), m; None where it does not."""
    place = crossing(loop, loop)
    if place is not None:
        return place
    corners = loop.polygon
    count = len(corners)
    step = np.roll(corners, -1, axis=0) - corners
    length = np.maximum((step**2).sum(axis=1), 1e-30)
    rows = max(1, PAIRS_AT_ONCE // count)
    for first in range(0, count, rows):
        number = np.arange(first, min(first + rows, count))
        away = corners[number, None] - corners
        t = np.clip((away * step).sum(axis=2) / length, 0.0, 1.0)
        far = np.sqrt(((away - t[..., None] * step) ** 2).sum(axis=2))
        far[np.arange(len(number)), number] = np.inf  # a side begins here
        far[np.arange(len(number)), number - 1] = np.inf  # and one ends
        if far.min() <= TOUCH:
            return np.asarray(corners[number[int(far.min(axis=1).argmin())]])
    return None


def crossing(one: Loop, other: Loop) -> Real | None:
    """Where two loops cross, (2,), m; None where they do not, or only touch."""
    p, q = one.polygon, other.polygon
    r, s = np.roll(p, -1, axis=0) - p, np.roll(q, -1, axis=0) - q
    r_length, s_length = np.maximum(np.hypot(*r.T), 1e-30), np.maximum(np.hypot(*s.T), 1e-30)
    rows = max(1, PAIRS_AT_ONCE // len(q))
    for first in range(0, len(p), rows):
        part = slice(first, first + rows)
        away = q - p[part, None]
        begin = _cross(r[part, None], away) / r_length[part, None]
        end = _cross(r[part, None], away + s) / r_length[part, None]
        back = _cross(away, s) / s_length
        forth = _cross(away - r[part, None], s) / s_length
        proper = (begin * end < 0.0) & (back * forth < 0.0)
        proper &= np.minimum(np.abs(begin), np.abs(end)) > 0.1 * TOUCH
        proper &= np.minimum(np.abs(back), np.abs(forth)) > 0.1 * TOUCH
        i, j = np.nonzero(proper)
        if one is not other and i.size:  # curves that touch or run along each other have chords that cross
            through = _through(one, other, i + first, j)
            i, j = i[through], j[through]
        if i.size:
            i, j = i[0], j[0]
            return np.asarray(q[j] + s[j] * begin[i, j] / (begin[i, j] - end[i, j]))
    return None


def leaves(inner: Loop, outer: Loop) -> Real | None:
    """Where a loop that is to lie inside another leaves it, (2,), m; None where it does not. They may touch."""
    points = just_inside(inner)
    out = ~outer.contains(points)
    if out.any():
        return np.asarray(points[out][int(outer.distance(points[out]).argmax())])
    return crossing(inner, outer)


def overlap(one: Loop, other: Loop) -> Real | None:
    """Where two loops cover the same area, (2,), m; None where they do not. They may touch."""
    (low, high), (left, right) = one.bounds, other.bounds
    if (high <= left).any() or (right <= low).any():
        return None
    for first, second in ((one, other), (other, one)):
        points = just_inside(first)
        inside = second.contains(points)
        if inside.any():
            return np.asarray(points[inside][int(second.distance(points[inside]).argmax())])
    return crossing(one, other)


def gap(one: Loop, other: Loop) -> tuple[float, Real]:
    """Smallest distance between two loops, m, and where it is, (2,), m."""
    found = []
    for first, second in ((one, other), (other, one)):
        away = second.nearest(first.polygon).distance  # on the curve: chords are up to 0.1 mm away from it
        found.append((float(away.min()), first.polygon[int(away.argmin())]))
    return min(found, key=lambda pair: pair[0])


def just_inside(loop: Loop) -> Real:
    """Points (K, 2) all along a loop, `TOUCH` inside of it, m."""
    start = loop.polygon
    step = np.roll(start, -1, axis=0) - start
    length = np.hypot(*step.T)
    pieces = np.maximum(np.ceil(PIECES_OF_LOOP * length / max(float(length.sum()), 1e-30)), 1).astype(int)
    side = np.repeat(np.arange(len(start)), pieces)
    share = (np.arange(len(side)) - np.repeat(np.cumsum(pieces) - pieces, pieces) + 0.5) / pieces[side]
    point, along = loop.over_sides(side, share)
    inward = np.stack([-along[:, 1], along[:, 0]], axis=1)
    return np.asarray(point + TOUCH * inward / np.maximum(np.hypot(*along.T), 1e-30)[:, None])


def _through(one: Loop, other: Loop, i: Whole, j: Whole) -> Mask:
    """Whether curves cross of which sides i of a loop's polygon and j of another's (K,) are chords."""
    found = np.zeros(len(i), bool)
    share = np.linspace(0.0, 1.0, POINTS_OVER_CHORD)
    for loop, sides, far in ((one, i, other), (other, j, one)):
        points, _ = loop.over_sides(np.repeat(sides, POINTS_OVER_CHORD), np.tile(share, len(sides)))
        inside = np.where(far.contains(points), 1.0, -1.0) * far.nearest(points).distance
        inside = inside.reshape(-1, POINTS_OVER_CHORD)
        found |= (inside.min(axis=1) < -TOUCH) & (inside.max(axis=1) > TOUCH)
    return found


def _cross(one: Real, other: Real) -> Real:
    return np.asarray(one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0])
