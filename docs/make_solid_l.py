"""Make the modes of an L of solids again: python docs/make_solid_l.py. CalculiX takes about ten minutes.

CalculiX (ccx, Debian's calculix-ccx) writes stiffness and mass of a free L with a round hole, of C3D20R two layers
thick, refined towards the inner corner, where the stresses are singular: without that the first frequencies come
out 0.01 % high, which at a loss factor of 0.5 % changes the response at a resonance by 4 %. Stored beside tests
are the modes at some points, and what all higher modes give there: with them, masses and springs at these points
can be added without another solution. Frequencies are extrapolated from two meshes.
"""

import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import scipy.sparse as sparse
import scipy.sparse.linalg as linear
from solid_cases import l_blocks, lines, middle
from solid_plate import Block, Layer, Mesh, Solid, meshed, solved

from analysis.arrays import Real, Whole

FILE = Path(__file__).resolve().parents[1] / "tests" / "app" / "plate_frfs" / "solid_l.npz"
THICKNESS, SPACING = 0.004, 0.025
CORNER = (0.18, 0.14)
AROUND_CORNER = np.array([-6.0, -3.0, -1.5, -0.6, 0.0, 0.6, 1.5, 3.0, 6.0]) * 1e-3
"""Ends of the cells about the inner corner, m from it."""
POINTS = np.array([
    (0.03, 0.04),  # where the hammer strikes
    (0.15, 0.27), (0.37, 0.11), (0.09, 0.13),  # accelerometers
    (0.33, 0.125), (0.015, 0.285), (0.385, 0.015),  # a cable, two strings
    (0.06, 0.21), (0.18, 0.30), (0.22, 0.05),  # nothing is declared there
])  # fmt: skip
SIMPSON = np.array([1.0, 4.0, 2.0, 4.0, 1.0]) / 12.0
"""Weights of the mean over two layers of quadratic elements."""
MODES, EXTRAPOLATED = 110, 40
ORDER = 4.0
"""Of convergence of quadratic elements in the energy, away from singular points."""
SHIFT = (2.0 * np.pi * 300.0) ** 2
"""rad2/s2: a free plate has no static answer, but one on an elastic foundation has."""
SPOT, SPOT_STIFFNESS = ((0.075, 0.105), (0.20, 0.23)), 0.8
"""A square that is weaker in one of the plates, m, and by how much."""
ALUMINIUM, PLASTIC = Solid((70e9, 0.33), 2700.0), Solid((1.5e9, 0.40), 905.0)
WEAKER = Solid((SPOT_STIFFNESS * 70e9, 0.33), 2700.0)
PLATES = {
    "aluminium": {"PLATE": ALUMINIUM, "SPOT": ALUMINIUM},
    "weak spot": {"PLATE": ALUMINIUM, "SPOT": WEAKER},
    "polypropylene": {"PLATE": PLASTIC, "SPOT": PLASTIC},
}


@dataclass(frozen=True)
class Modes:
    """Modes of a free solid at points.

    Attributes
    ----------
    squares : (N,) ndarray
        Squares of the angular frequencies, rad2/s2, ascending.
    shapes : (P, N) ndarray
        Deflections, of unit modal mass.
    higher : (P, P) ndarray
        Compliance of all higher modes, m/N.
    places : (P, 2) ndarray
        Near the points asked for, m.
    mass : float
        kg.
    """

    squares: Real
    shapes: Real
    higher: Real
    places: Real
    mass: float


def blocks(layers: int, refinement: int) -> list[Block]:
    """Return the blocks of the L, so many layers thick when they are refined."""
    x = lines((0.0, 0.40), THICKNESS, SPACING, sorted((*(CORNER[0] + AROUND_CORNER), 0.25, 0.35, *SPOT[0])))
    y = lines((0.0, 0.30), THICKNESS, SPACING, sorted((0.02, 0.12, *(CORNER[1] + AROUND_CORNER), *SPOT[1])))
    found = l_blocks(x, y, THICKNESS)
    low, high = np.array(SPOT).T
    inside = [bool((low < middle(one)).all() and (middle(one) < high).all()) for one in found]
    half, cells = 0.5 * THICKNESS, layers / refinement
    layer = {spot: (Layer(-half, half, "SPOT" if spot else "PLATE", cells),) for spot in (False, True)}
    return [Block(one.place, one.cells, layer[spot]) for one, spot in zip(found, inside, strict=True)]


def modes(materials: dict[str, Solid], refinement: int, count: int = MODES) -> Modes:
    """Solve for the modes on a mesh."""
    mesh = meshed(blocks(2, refinement), refinement)
    stiffness, mass, node, direction = matrices(mesh, materials)
    average, places = through_thickness(mesh, node, direction)
    solver = linear.splu((stiffness + SHIFT * mass).tocsc())
    inverse = linear.LinearOperator(stiffness.shape, matvec=solver.solve)
    squares, shapes = linear.eigsh(stiffness, k=count, M=mass, sigma=-SHIFT, OPinv=inverse)
    at = average @ shapes
    higher = average @ solver.solve(average.T.toarray()) - (at / (squares + SHIFT)) @ at.T
    up = (direction == 2).astype(float)
    return Modes(squares, at, higher, places, float(up @ (mass @ up)))


def through_thickness(mesh: Mesh, node: Whole, direction: Whole) -> tuple[sparse.csr_matrix, Real]:
    """Return the mean deflection (P, D) through the thickness near each point, and its place (P, 2), m.

    A force on one node would press a dent into the face, deeper the finer the mesh: on plastic that dent alone
    lets an accelerometer resonate. On the mean over several places a wave of the band acts less than on a point.
    """
    up = {one: row for row, one in enumerate(node) if direction[row] == 2}
    _, line, count = np.unique(np.round(mesh.nodes[:, :2], 9), axis=0, return_inverse=True, return_counts=True)
    ends = np.flatnonzero(
        count[line.ravel()] == SIMPSON.size
    )  # corners of elements, not the middles of their sides
    average = sparse.lil_matrix((len(POINTS), node.size))
    places = []
    for number, point in enumerate(POINTS):
        nearest = ends[np.argmin(np.hypot(*(mesh.nodes[ends, :2] - point).T))]
        under = np.flatnonzero(line.ravel() == line.ravel()[nearest])
        under = under[np.argsort(mesh.nodes[under, 2])]
        average[number, [up[one] for one in under]] = SIMPSON
        places.append(mesh.nodes[nearest, :2])
    return average.tocsr(), np.array(places)


def matrices(mesh: Mesh, materials: dict[str, Solid]) -> tuple[sparse.csc_matrix, sparse.csc_matrix, Whole, Whole]:
    """Return stiffness and mass, (D, D), and node and direction of each of the D displacements."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        solved(folder, mesh, materials, ["*FREQUENCY, SOLVER=MATRIXSTORAGE", "1"])
        named = np.loadtxt(folder / "plate.dof")  # 12.3 is node 12, direction 3
        found = []
        for ending in ("sti", "mas"):
            row, column, value = np.loadtxt(folder / f"plate.{ending}").T
            places = (row.astype(int) - 1, column.astype(int) - 1)
            half = sparse.coo_matrix((value, places), shape=(named.size, named.size)).tocsc()
            found.append((half + half.T - sparse.diags(half.diagonal())).tocsc())
    node = np.floor(named + 1e-6).astype(int)
    return found[0], found[1], node - 1, np.round(10.0 * (named - node)).astype(int) - 1


def main() -> None:
    """Solve, extrapolate, store."""
    coarse, fine = (modes(PLATES["aluminium"], refinement, EXTRAPOLATED).squares for refinement in (2, 3))
    exact = fine - (coarse - fine) / (1.5**ORDER - 1.0)
    finer = np.concatenate([np.zeros(6), (exact / coarse)[6:], np.ones(MODES - EXTRAPOLATED)])  # six rigid motions
    stored = {}
    for name, materials in PLATES.items():
        found = modes(materials, 2)
        found = replace(found, squares=found.squares * finer)
        stored |= {f"{name} {key}": value for key, value in vars(found).items()}
        print(name, np.sqrt(found.squares[6:20]) / (2.0 * np.pi))
    np.savez_compressed(FILE, **stored)


if __name__ == "__main__":
    main()
