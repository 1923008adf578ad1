"""Supports along edges and on discs: functions held at zero, and springs."""

from collections.abc import Iterator

import numpy as np
from numpy.polynomial.legendre import leggauss

from analysis.arrays import Mask, Real, Whole
from analysis.declaration.outline import SupportedEdge
from analysis.declaration.plate import Plate
from simulation.meshing.plate_mesh import CURVE_DEGREE, BorderEdges
from simulation.shell.rigidity import THX, THY, U, V, W
from simulation.shell.shape_functions import lobatto
from simulation.shell.space import ShapeSpace

LineBlock = tuple[int, int, Whole, Real]
"""Two fields, functions (K, m) of K edges, and their matrices (K, m, m)."""

ROTATION_PENALTY = 1e16
"""Penalty on the rotation along an oblique hard edge, over h**2 / 12, Pa.

From 1e4 to 1e8 bending stiffnesses per thickness h give equal results (errors of a disc below 1e-6): this is 5e4
of steel and 1e7 of polypropylene.
"""


def held_functions(space: ShapeSpace, plate: Plate) -> Mask:
    """Functions of every field that supports hold at zero, (5, N)."""
    held = np.zeros((5, space.size), bool)
    for one in plate.supported_edges():
        edges = supported(space, one)
        fields = {"soft-simple": (W,), "hard-simple": (W,), "clamped": (U, V, W, THX, THY)}
        for field in fields.get(one.support.kind, ()):
            held[field] |= space.on_edges(edges)
        if one.support.kind == "hard-simple":
            along_x, along_y = straight_edges(space, edges)
            held[THX] |= space.on_edges(edges[along_x])
            held[THY] |= space.on_edges(edges[along_y])
    for name, (support, _) in plate.supported_discs().items():
        if support.kind == "clamped":
            held[:, space.on_cells(space.mesh.inside[name])] = True
    return held


def supported(space: ShapeSpace, one: SupportedEdge) -> Whole:
    """Mesh edges that a support holds, (K,)."""
    border = space.mesh.borders["outline" if one.loop == 0 else f"hole {one.loop}"]
    return np.concatenate([border.edge[_within(border, *piece)] for piece in one.pieces])


def spring_blocks(space: ShapeSpace, plate: Plate, *, damping: bool = False) -> Iterator[LineBlock]:
    """Springs along elastic edges, or their dashpots, and the penalty of oblique hard ones.

    Parameters
    ----------
    damping : bool
        Whether to yield the dashpots instead.

    Yields
    ------
    LineBlock
        Two fields, functions (K, m), and matrices (K, m, m).
    """
    for one in plate.supported_edges():
        support, edges = one.support, supported(space, one)
        if support.kind == "elastic":
            across = support.damping if damping else support.translation
            about = support.rotation_damping if damping else support.rotation
            if across:
                yield from line_blocks(space, edges, {W: None}, across)
            if about:
                yield from line_blocks(space, edges, {THX: 0, THY: 1}, about, normal=True)
        elif support.kind == "hard-simple" and not damping:
            along_x, along_y = straight_edges(space, edges)
            oblique = edges[~(along_x | along_y)]
            if oblique.size:
                yield from line_blocks(space, oblique, {THX: 0, THY: 1}, penalty(plate), normal=False)


def penalty(plate: Plate) -> float:
    """Stiffness against the rotation along an oblique hard edge, N m/rad per m."""
    return ROTATION_PENALTY * plate.thickness**2 / 12.0


def straight_edges(space: ShapeSpace, edges: Whole) -> Mask:
    """Which mesh edges are parallel to x, and which to y, (2, K)."""
    ends = space.mesh.points[space.mesh.edges[edges]]
    step = np.abs(ends[:, 1] - ends[:, 0])
    flat = ~space.mesh.bow[edges].any(axis=(1, 2))
    return np.stack([flat & (step[:, 1] < 1e-9 * step[:, 0]), flat & (step[:, 0] < 1e-9 * step[:, 1])])


def _within(border: BorderEdges, curve: int, first: float, last: float) -> Mask:
    middle = border.span.mean(axis=1)
    return np.asarray((border.curve == curve) & (middle > first) & (middle < last))


def line_blocks(
    space: ShapeSpace, edges: Whole, fields: dict[int, int | None], stiffness: float, normal: bool = True
) -> Iterator[LineBlock]:
    """Integral along edges of stiffness times the square of a field, or of the rotation in one direction.

    Parameters
    ----------
    edges : (K,) ndarray of int
    fields : dict of int to int or None
        Fields and, for a rotation, its component (0 or 1) in the plane.
    stiffness : float
        Per length: N/m2 for a deflection, N for a rotation; of dashpots times s.
    normal : bool
        Whether the rotation is that of the normal direction; else of the tangent.

    Yields
    ------
    LineBlock
        Two fields, functions (K, m), and matrices (K, m, m).
    """
    nodes, weights = leggauss(space.degree + 3 + CURVE_DEGREE // 2)
    value = np.vstack([0.5 * (1.0 - nodes), 0.5 * (1.0 + nodes), lobatto(space.degree, nodes)[0]])
    slope = lobatto(CURVE_DEGREE, nodes)[1]
    ends = space.mesh.points[space.mesh.edges[edges]]
    along = 0.5 * (ends[:, 1] - ends[:, 0])[:, None] + np.einsum("kcd,cq->kqd", space.mesh.bow[edges], slope)
    speed = np.hypot(along[..., 0], along[..., 1])
    tangent = along / speed[..., None]
    functions = np.hstack([space.mesh.edges[edges], space.edge_functions(edges)])
    toward = np.stack([tangent[..., 1], -tangent[..., 0]], axis=-1) if normal else tangent
    names = list(fields)
    for k, f in enumerate(names):
        for g in names[k:]:
            weight = stiffness * weights * speed
            for axis in (fields[f], fields[g]):
                if axis is not None:
                    weight = weight * toward[..., axis]
            yield f, g, functions, np.einsum("iq,kq,jq->kij", value, weight, value, optimize=True)
