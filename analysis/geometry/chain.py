"""Loose curves, as drawings hold them, put together into closed loops."""

from collections.abc import Sequence

import numpy as np

from analysis.arrays import Real
from analysis.geometry.curves import Curve, Segment, moved
from analysis.geometry.fault import GeometryError, at
from analysis.geometry.loop import Loop


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
