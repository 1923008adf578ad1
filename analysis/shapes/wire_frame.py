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
    nodes, place = _seen(points)
    if len(np.unique(place, axis=0)) < 2:
        return []
    if _on_a_line(place):
        return [[nodes[n] for n in np.argsort(place[:, 0], kind="stable")]]
    _, short = _triangles(place)
    return [[nodes[a], nodes[b]] for a, b in sorted(short)]


def faces_between(points: Mapping[int, Position]) -> list[tuple[int, int, int]]:
    """Return the corners of triangles between `lines_between`; none for nodes on one line."""
    nodes, place = _seen(points)
    if len(nodes) < 3 or _on_a_line(place):
        return []
    corners, short = _triangles(place)
    return [(nodes[a], nodes[b], nodes[c]) for a, b, c in corners if short.issuperset(_sides((a, b, c)))]


def _seen(points: Mapping[int, Position]) -> tuple[list[int], Real]:
    """Return the nodes that are somewhere, and their places (N, 2) along their two longest extents."""
    nodes = sorted(node for node, place in points.items() if np.isfinite(place).all())
    place = np.array([points[node] for node in nodes]).reshape(-1, 3)
    if not nodes:
        return [], np.zeros((0, 2))
    centred = place - place.mean(axis=0)
    axes = np.linalg.svd(centred, full_matrices=False)[2]
    return nodes, centred @ axes[:2].T


def _on_a_line(place: Real) -> bool:
    along, across = np.linalg.norm(place, axis=0)
    return bool(across <= FLAT * along)


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
