"""Lines and faces between the measuring points of a structure, where nobody has declared any."""

from collections.abc import Mapping

import numpy as np

from analysis.arrays import Real

Position = tuple[float, float, float]

LONGEST = 1.5
"""Length of a line, over the median, beyond which it is not drawn: it would cross a hole or close a bay."""
FLAT = 1e-6
"""Smallest extent across, over that along, of nodes that do not lie on one line."""


def lines_between(points: Mapping[int, Position]) -> list[list[int]]:
    """Return nodes to be joined, in this order: those of one line along it, others by the edges of triangles.

    Parameters
    ----------
    points : mapping of int to (float, float, float)

    Returns
    -------
    list of list of int
        Empty for fewer than two places; nodes that are nowhere are joined to none.
    """
    nodes, place = _known(points)
    if not nodes or len(np.unique(place, axis=0)) < 2:
        return []
    centred = place - place.mean(axis=0)
    _, size, axes = np.linalg.svd(centred, full_matrices=False)
    if len(size) < 2 or size[1] <= FLAT * size[0]:
        return [[nodes[n] for n in np.argsort(centred @ axes[0], kind="stable")]]
    _, short = _triangles(centred @ axes[:2].T)
    return [[nodes[a], nodes[b]] for a, b in sorted(short)]


def faces_between(points: Mapping[int, Position]) -> list[tuple[int, int, int]]:
    """Return the corners of triangles between `lines_between`; none for nodes on one line."""
    nodes, place = _known(points)
    if len(nodes) < 3:
        return []
    centred = place - place.mean(axis=0)
    _, size, axes = np.linalg.svd(centred, full_matrices=False)
    if size[1] <= FLAT * size[0]:
        return []
    corners, short = _triangles(centred @ axes[:2].T)
    return [(nodes[a], nodes[b], nodes[c]) for a, b, c in corners if short.issuperset(_sides((a, b, c)))]


def _known(points: Mapping[int, Position]) -> tuple[list[int], Real]:
    nodes = sorted(node for node, place in points.items() if np.isfinite(place).all())
    return nodes, np.array([points[node] for node in nodes]).reshape(-1, 3)


def _triangles(flat: Real) -> tuple[list[tuple[int, int, int]], set[tuple[int, int]]]:
    """Return Delaunay's triangles of points (N, 2) in a plane, and those of their sides that are short."""
    from scipy.spatial import Delaunay  # slow import

    found = [(int(a), int(b), int(c)) for a, b, c in Delaunay(flat).simplices]
    length = {(a, b): float(np.linalg.norm(flat[a] - flat[b])) for one in found for a, b in _sides(one)}
    longest = LONGEST * float(np.median(list(length.values())))
    return found, {edge for edge, long in length.items() if long <= longest}


def _sides(corners: tuple[int, int, int]) -> list[tuple[int, int]]:
    a, b, c = sorted(corners)
    return [(a, b), (b, c), (a, c)]
