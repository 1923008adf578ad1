"""Cases of docs/make_verification.py by the shell of `simulation`: its bending alone."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import LinearOperator, eigsh
from scipy.spatial import cKDTree

from analysis.arrays import Real, Whole
from simulation.meshing.mesher import Border, mesh_plate
from simulation.meshing.plate_mesh import MeshRecipe, PlateMesh
from simulation.shell.edges import line_blocks, straight_edges
from simulation.shell.rigidity import SHEAR_FACTOR, THX, THY, CellMatrices, Rigidity, W, laminate
from simulation.shell.shape_functions import map_cells, quad_functions, triangle_functions
from simulation.shell.space import ShapeSpace
from simulation.shell.unknowns import Unknowns, factorize
from tests.simulation.verification.case import Case

DEGREE = 6
COARSEST = 0.45
"""Largest edge of a cell of the coarsest mesh, in roots of the plate's area."""
THICKNESS = 0.003
"""For which recipes give their spacing, m."""
PENALTY = 1e5
"""On the rotation along curved and oblique hard edges, in bending stiffnesses per thickness."""
DRAWN = 7
"""Points along the side of a cell at which modes are drawn."""


def solve_plate(case: Case, refinement: int) -> tuple[Real, list[Real], Real, Whole, Real]:
    """Frequencies, cells, points, triangles and deflections, as `Solved` has them."""
    space = ShapeSpace.on(_mesh(case, refinement), DEGREE)
    unknowns = Unknowns.of(space, _kept(case, space))
    cells, material, h = CellMatrices(space), case.material, case.thickness
    shear = material.youngs_modulus / (2.0 * (1.0 + material.poisson_ratio))
    nu, d = material.poisson_ratio, case.rigidity
    bending = [[d, nu * d, 0.0], [nu * d, d, 0.0], [0.0, 0.0, 0.5 * (1.0 - nu) * d]]
    none = [[0.0] * 3] * 3
    across = SHEAR_FACTOR * shear * h
    stiffness = unknowns.matrix(cells.of(Rigidity(laminate(none, None, bending, (across, across, 0.0)))))
    for _, number in _edges(case, space.mesh, "hard"):
        oblique = number[~straight_edges(space, number).any(axis=0)]
        if oblique.size:
            stiffness += unknowns.lines(
                line_blocks(space, oblique, {THX: 0, THY: 1}, PENALTY * d / h, normal=False)
            )
    mass = material.density * h
    inertia = unknowns.matrix(cells.inertia(mass, None, mass * h**2 / 12.0))
    shift = -((2.0 * np.pi * 0.5 * case.reference[0]) ** 2)
    squares, vectors = eigsh(
        stiffness,
        case.rigid_motions + case.reference.size,
        inertia,
        sigma=shift,
        OPinv=LinearOperator(stiffness.shape, matvec=factorize(stiffness - shift * inertia).solve, dtype=float),
        v0=np.random.default_rng(0).standard_normal(unknowns.size),
    )
    order = np.argsort(squares)
    frequency = np.sqrt(np.abs(squares[order])) / (2.0 * np.pi)
    whole = np.zeros((5 * space.size, len(order)))
    whole[unknowns.chosen] = vectors[:, order]
    return frequency, _outlines(space.mesh), *_drawn(space, whole.reshape(5, space.size, -1)[W].T)


def _mesh(case: Case, refinement: int) -> PlateMesh:
    spacing = COARSEST * float(np.sqrt(case.area)) / 2**refinement
    recipe = MeshRecipe(
        spacing=spacing / (case.thickness / THICKNESS) ** 0.5,
        edge_strip=1.5,
        grading=0.2,
        levels=2 + 2 * refinement,
        outer_corners=True,
    )
    borders = [Border("outline", case.outline, "outline")]
    borders += [Border(f"hole {k}", hole, "hole") for k, hole in enumerate(case.holes, start=1)]
    return mesh_plate(borders, case.thickness, recipe)


def _edges(case: Case, mesh: PlateMesh, support: str) -> list[tuple[str, Whole]]:
    """Edges of the mesh with a support, border by border."""
    found = []
    for k, (_, supports) in enumerate(case.loops):
        name = f"hole {k}" if k else "outline"
        held = [curve for curve, given in enumerate(supports) if given == support]
        found.append((name, mesh.borders[name].edge[np.isin(mesh.borders[name].curve, held)]))
    return found


def _kept(case: Case, space: ShapeSpace) -> NDArray[np.bool_]:
    """Functions that supports leave free, (5, N): bending alone."""
    kept = np.zeros((5, space.size), bool)
    kept[[W, THX, THY]] = True
    for support, fields in (("soft", (W,)), ("hard", (W,)), ("clamped", (W, THX, THY))):
        for _, number in _edges(case, space.mesh, support):
            for field in fields:
                kept[field] &= ~space.on_edges(number)
            if support == "hard":
                for field, straight in zip((THX, THY), straight_edges(space, number), strict=True):
                    kept[field] &= ~space.on_edges(number[straight])
    return kept


def _outlines(mesh: PlateMesh) -> list[Real]:
    """Points along the border of every cell."""
    s, one = np.linspace(-1.0, 1.0, DRAWN)[:-1], np.ones(DRAWN - 1)
    square = np.hstack([[s, -one], [one, s], [-s, one], [-one, -s]])
    t = 0.5 * (s + 1.0)
    triangle = np.hstack([[t, 0 * t], [1 - t, t], [0 * t, 1 - t]])
    return [*map_cells(mesh, square, False)[0], *map_cells(mesh, triangle, True)[0]]


def _drawn(space: ShapeSpace, coefficients: Real) -> tuple[Real, Whole, Real]:
    """Points, triangles and values (K, N) of functions with coefficients (K, n), cell by cell."""
    i, j = (grid.ravel() for grid in np.mgrid[:DRAWN, :DRAWN])
    square = np.array([i, j]) / (DRAWN - 1)
    lower = np.array([k for k in range(DRAWN**2) if i[k] < DRAWN - 1 and j[k] < DRAWN - 1])
    halves = np.vstack([
        np.stack([lower, lower + DRAWN, lower + 1], axis=1),
        np.stack([lower + DRAWN, lower + DRAWN + 1, lower + 1], axis=1),
    ])  # fmt: skip
    points, triangles, values, first = [], [], [], 0
    for group, kind in zip(space.groups, (False, True), strict=True):
        used = halves[(i[halves] + j[halves] < DRAWN).all(axis=1)] if kind else halves
        places = square if kind else 2.0 * square - 1.0
        inside = np.unique(used)
        table = (triangle_functions if kind else quad_functions)(space.degree, places[:, inside])
        x, _ = map_cells(space.mesh, places[:, inside], kind)
        points.append(x.reshape(-1, 2))
        local = np.searchsorted(inside, used)
        count = len(group.functions)
        triangles.append((first + np.arange(count)[:, None, None] * inside.size + local).reshape(-1, 3))
        value = np.einsum("kcn,nq->kcq", coefficients[:, group.functions] * group.sign, table.value)
        values.append(value.reshape(len(coefficients), -1))
        first += count * inside.size
    return _merged(np.vstack(points), np.vstack(triangles), np.hstack(values))


def _merged(points: Real, triangles: Whole, values: Real) -> tuple[Real, Whole, Real]:
    """Make one point of those that neighbouring cells share: what is left without a neighbour is the outline."""
    close = 1e-11 * float(np.ptp(points, axis=0).max())
    first = np.array([min(same) for same in cKDTree(points).query_ball_point(points, close)])
    kept, number = np.unique(first, return_inverse=True)
    return points[kept], number[triangles], values[:, kept]
