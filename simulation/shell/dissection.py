"""Nested dissection of a mesh: elimination order for sparse factors (George, SIAM J. Numer. Anal. 10, 1973).

Cells are halved by straight cuts, recursively. The functions common to both halves are eliminated after both, so
that until then the halves are uncoupled.
"""

import numpy as np

from analysis.arrays import Mask, Real, Whole

DIRECTIONS = 8
"""Directions of the cuts that are tried."""
LEAST_SIDE_SHARE = 0.35
"""Smallest share of the functions on one side of a cut, if the cells allow it."""
UNEVEN_PENALTY = 4.0
"""Penalty on the cost of a cut for unequal sides: factor on the squared deviation of their shares from a half."""

CELLS_NOT_HALVED = 2
"""Largest number of cells that is not halved further: it would cost more than it saves."""


def dissected(members: Whole, size: Real, places: Real) -> Whole:
    """Order the parts of cells, for example points and edges, for elimination.

    Parameters
    ----------
    members : (C, K) ndarray of int
        Parts of every cell; -1 where it has fewer.
    size : (P,) ndarray
        Functions on every part.
    places : (C, 2) ndarray
        Middles of the cells, m.

    Returns
    -------
    ndarray of int
        Every part of a cell once.
    """
    angles = np.arange(DIRECTIONS) * np.pi / DIRECTIONS
    along = np.array([np.cos(angles), np.sin(angles)]).T @ places.T
    left = np.ones(len(size), bool)
    order: list[Whole] = []

    def eliminate(cells: Whole) -> None:
        parts = members[cells]
        used = (parts >= 0) & left[parts]
        inside, which = np.unique(parts[used], return_inverse=True)
        if not inside.size:
            return
        last = inside
        if len(cells) > CELLS_NOT_HALVED:
            row = np.nonzero(used)[0]
            cuts = [_cut(one, row, which, size[inside]) for one in along[:, cells]]
            _, before, shared = min(cuts, key=lambda cut: cut[0])
            last = inside[shared]
            left[last] = False
            eliminate(cells[before])
            eliminate(cells[~before])
        left[last] = False
        order.append(last)

    eliminate(np.arange(len(members)))
    return np.concatenate(order)


def _cut(along: Real, row: Whole, which: Whole, size: Real) -> tuple[float, Mask, Mask]:
    """Cheapest cut across a direction: its cost, the cells (C,) before it, the parts (P,) on both its sides.

    `along` (C,) are places of the cells; each incidence of a part and a cell is one of `which` and one of `row`.
    """
    count = len(along)
    rank = np.empty(count, int)
    rank[np.argsort(along, kind="stable")] = np.arange(count)
    first, last = np.full(size.size, count), np.zeros(size.size, int)
    np.minimum.at(first, which, rank[row])
    np.maximum.at(last, which, rank[row])
    # of the cut before each cell but the first: functions of parts wholly before it, and of those on both sides
    before = np.cumsum(np.bincount(last + 1, size, count + 1))[1:count]
    shared = np.cumsum(np.bincount(first + 1, size, count + 1))[1:count] - before
    uneven = np.abs(before / np.maximum(size.sum() - shared, 1.0) - 0.5)
    cost = np.where(
        uneven <= max(0.5 - LEAST_SIDE_SHARE, uneven.min()), shared * (1.0 + UNEVEN_PENALTY * uneven**2), np.inf
    )
    cut = int(cost.argmin()) + 1
    return float(cost[cut - 1]), rank < cut, (first < cut) & (last >= cut)
