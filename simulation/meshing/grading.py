"""Refinement of cells next to corners, where stresses are singular."""

from collections.abc import Callable

import numpy as np

from analysis.arrays import Real
from simulation.meshing.cells import Cells, Path


def graded(cells: Cells, share: float, corners: set[int]) -> None:
    """Split every quadrilateral at a corner into three, the smallest next to the corner.

    Parameters
    ----------
    cells : Cells
        Changed in place.
    share : float
        Share of an edge at a corner taken by the smallest cell.
    corners : set of int
        Points; a quadrilateral has one of them at most.
    """
    made: dict[tuple[int, int], int] = {}

    def along(corner: int, other: int) -> int:
        if (corner, other) not in made:
            made[corner, other] = _cut(cells, corner, other, share)
        return made[corner, other]

    quads, owners = [], []
    for quad, face in zip(cells.quads, cells.quad_face, strict=True):
        touched = [k for k in range(4) if quad[k] in corners]
        if not touched:
            quads.append(quad)
            owners.append(face)
            continue
        a, b, c, d = (quad[(touched[0] + k) % 4] for k in range(4))
        one, two = along(a, b), along(a, d)
        p = [cells.points[k] for k in (a, b, c, d)]
        middle = cells.add((1 - share) ** 2 * p[0] + share * (1 - share) * (p[1] + p[3]) + share**2 * p[2])
        quads += [(a, one, middle, two), (one, b, c, middle), (two, middle, c, d)]
        owners += [face] * 3
    cells.quads, cells.quad_face = quads, owners


def corners_apart(cells: Cells, wanted: set[int], triangles: set[int]) -> set[int]:
    """Corners that can be graded: no triangle touches them, and no quadrilateral has two of them.

    Parameters
    ----------
    wanted : set of int
        Points to be graded.
    triangles : set of int
        Points that triangles touch.

    Returns
    -------
    set of int
        Of the points wanted.
    """
    found = wanted - triangles
    for quad in cells.quads:
        touched = found & set(quad)
        if len(touched) > 1:
            found -= touched
    return found


def path_between(cells: Cells, a: int, b: int) -> tuple[Path, bool]:
    """Path along the edge between two points.

    Parameters
    ----------
    a, b : int
        Numbers of the points.

    Returns
    -------
    path : callable
        From parameters (...) in 0 to 1 to points (..., 2), m.
    forward : bool
        Whether it runs from `a` to `b`.
    """
    if (a, b) in cells.paths:
        return cells.paths[a, b], True
    if (b, a) in cells.paths:
        return cells.paths[b, a], False
    start, end = cells.points[a], cells.points[b]
    return (lambda t: np.asarray(start + np.asarray(t, float)[..., None] * (end - start))), True


def part_of(path: Path, first: float, last: float) -> Callable[[Real], Real]:
    """Return the path between two of its parameters.

    Parameters
    ----------
    path : callable
        From parameters (...) in 0 to 1 to points (..., 2), m.
    first, last : float
        Parameters between which it is taken; it is run backwards where `first` is the larger.

    Returns
    -------
    callable
        Of the same kind, again over 0 to 1.
    """
    return lambda t: path(first + np.asarray(t, float) * (last - first))


def _cut(cells: Cells, corner: int, other: int, share: float) -> int:
    """Cut the edge between a corner and another point; return the new point."""
    path, forward = path_between(cells, corner, other)
    new = cells.add(path(np.array(share if forward else 1.0 - share)))
    if (corner, other) in cells.paths or (other, corner) in cells.paths:
        for a, b, first, last in ((corner, new, 0.0, share), (new, other, share, 1.0)):
            ends = (first, last) if forward else (1.0 - first, 1.0 - last)
            cells.paths[a, b] = part_of(path, *ends)
    for pair in ((corner, other), (other, corner)):
        if pair in cells.on_edge:
            edge, first, last = cells.on_edge.pop(pair)
            here, there = (first, last) if pair[0] == corner else (last, first)
            place = here + share * (there - here)
            cells.on_edge[corner, new] = (edge, here, place)
            cells.on_edge[new, other] = (edge, place, there)
    return new
