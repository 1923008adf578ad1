"""Energies of polynomial motions under laminates, against integrals by hand."""

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

from analysis.experiment import Patch, Plate
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.shell.rigidity import THX, THY, CellMatrices, CurvedSurface, Rigidity, U, V, W, laminate, moduli
from simulation.shell.shell_plate import ShellPlate
from simulation.shell.space import ShapeSpace
from simulation.shell.unknowns import Unknowns

A, B, H = 0.2, 0.1, 0.003
NONE = np.zeros((3, 3)).tolist()
WHOLE_FACE = Patch(id="A", role="actuator", center=(A / 2, B / 2), size=(A, B), thickness=0.0005)


@pytest.fixture(scope="module")
def space() -> ShapeSpace:
    plate = Plate(length_x=A, length_y=B, thickness=H, mass=0.06)
    return ShellPlate.of(plate, recipe=MeshRecipe(spacing=0.1, edge_strip=4.0, grading=0.0), degree=4).space


@pytest.fixture(scope="module")
def everything(space) -> Unknowns:
    return Unknowns.of(space, np.ones((5, space.size), bool))


@pytest.fixture(scope="module")
def motion(space):
    """Functions of x and y -> their coefficients, exact up to degree 4."""
    x, y = space.points.T
    mass = space.product("0", "0").tocsc()
    return lambda function: spsolve(mass, space.moments("0", function(x, y) + 0.0 * x))


@pytest.fixture(scope="module")
def energy(space, everything):
    cells = CellMatrices(space)

    def of(entries, parts) -> float:
        whole = everything.vector(parts)
        return float(whole @ (everything.matrix(cells.of(Rigidity(tuple(entries)))) @ whole))

    return of


def integral(m: int, n: int) -> float:
    return A ** (m + 1) / (m + 1) * B ** (n + 1) / (n + 1)


@pytest.mark.parametrize("first", [0, 3])
def test_energies_of_a_quadratic_motion(space, motion, energy, first):
    """Of u = x**2 + x y, v = y**2: e_x = 2 x + y, e_y = 2 y, g_xy = x; weight 1 + x. Rotations bend alike."""
    parts = {U: motion(lambda x, y: x**2 + x * y), V: motion(lambda x, y: y**2)}
    if first:
        parts = {THX: parts[U], THY: parts[V]}
    weight = 1.0 + space.points[:, 0]

    def weighed(m, n):
        return integral(m, n) + integral(m + 1, n)

    by_hand = {
        (0, 0): 4.0 * weighed(2, 0) + 4.0 * weighed(1, 1) + weighed(0, 2),
        (1, 1): 4.0 * weighed(0, 2),
        (0, 1): 2.0 * (4.0 * weighed(1, 1) + 2.0 * weighed(0, 2)),
        (2, 2): weighed(2, 0),
        (0, 2): 2.0 * (2.0 * weighed(2, 0) + weighed(1, 1)),
    }
    for (i, j), wanted in by_hand.items():
        assert energy([((first + i, first + j), weight)], parts) == pytest.approx(wanted, rel=1e-10)


def test_weights_of_cells_add_up_and_are_those_of_their_points(space, motion, energy):
    parts = {U: motion(lambda x, y: x**2 * y), V: motion(lambda x, y: x * y**2)}
    left = (space.mesh.centers[:, 0] < 0.5 * A).astype(float)
    for place in ((0, 0), (1, 1), (0, 1), (2, 2)):
        halves = [energy([(place, share)], parts) for share in (left, 1.0 - left)]
        assert sum(halves) == pytest.approx(energy([(place, 1.0)], parts), rel=1e-12)
        assert halves[0] != pytest.approx(halves[1], rel=0.1)
        at_points = space.spread(left > 0.5).astype(float)
        assert energy([(place, at_points)], parts) == pytest.approx(halves[0], rel=1e-12)


def test_a_tilt_does_not_shear_but_each_half_of_it_does(motion, energy):
    """A tilt w = 3 x with thx = -3 is rigid; w alone or thx alone shears by 3."""
    shear = [((6, 6), 1.0), ((7, 7), 1.0)]
    tilt, turn = motion(lambda x, y: 3.0 * x), motion(lambda x, y: -3.0)
    assert abs(energy(shear, {W: tilt, THX: turn})) < 1e-12
    assert energy(shear, {W: tilt}) == pytest.approx(9.0 * A * B, rel=1e-10)
    assert energy(shear, {THX: turn}) == pytest.approx(9.0 * A * B, rel=1e-10)


def test_a_layer_off_the_middle_couples_stretch_and_bending(motion, energy):
    """A layer of thickness t at height z stores what its own motion u + z thx stores."""
    t, z = 0.001, 0.002
    q = np.array([[3.0, 1.0, 0.2], [1.0, 2.0, 0.1], [0.2, 0.1, 0.7]])
    u, v = motion(lambda x, y: x**2), motion(lambda x, y: x * y)
    thx, thy = motion(lambda x, y: x * y), motion(lambda x, y: y**2 - x)
    layer = laminate((t * q).tolist(), (t * z * q).tolist(), (t * z**2 * q).tolist(), (0.0, 0.0, 0.0))
    alone = laminate((t * q).tolist(), None, NONE, (0.0, 0.0, 0.0))
    wanted = energy(alone, {U: u + z * thx, V: v + z * thy})
    assert energy(layer, {U: u, V: v, THX: thx, THY: thy}) == pytest.approx(wanted, rel=1e-12)


def test_weights_per_cell_and_per_point_do_not_mix(space):
    plate = Plate(length_x=A, length_y=B, thickness=0.003, mass=1e3 * A * B * 0.003, curvature={"radius": 2.0})
    surface = CurvedSurface.of(plate, space.points)
    with pytest.raises(ValueError, match="all per point, or all per cell"):
        Rigidity((((0, 0), np.ones(space.mesh.cells)),), surface).terms()


@pytest.mark.parametrize("side", ["top", "bottom"])
def test_moments_of_a_patch_are_integrals_over_its_thickness(side):
    plate = Plate(length_x=A, length_y=B, thickness=H, mass=0.06)
    patch = WHOLE_FACE.model_copy(update={"side": side})
    shell = ShellPlate.of(plate, [patch], recipe=MeshRecipe(spacing=0.1, grading=0.0), degree=2)
    entries = dict(shell.patch_stiffness(shell.thickness).entries)
    z, weight = np.polynomial.legendre.leggauss(4)
    z = (1.0 if side == "top" else -1.0) * (0.5 * H + 0.5 * patch.thickness * (1.0 + z))
    moments = [0.5 * patch.thickness * (weight * z**k).sum() for k in range(3)]
    q11, q12 = shell.materials["NCE51"].stiffness
    for (i, j), q in {(0, 0): q11, (0, 1): q12, (2, 2): 0.5 * (q11 - q12)}.items():
        found = [entries[place] for place in ((i, j), (i, 3 + j), (3 + i, 3 + j))]
        assert np.array(found) == pytest.approx(q * np.outer(moments, np.ones(shell.space.mesh.cells)), rel=1e-12)


def test_a_plate_shears_by_five_sixths_of_its_modulus():
    e, nu = 2e9, 0.37
    plate = Plate(length_x=A, length_y=B, thickness=H, mass=0.06)
    shell = ShellPlate.of(plate, recipe=MeshRecipe(spacing=0.1, grading=0.0), degree=2)
    c1 = e / (1 - nu**2)
    q = moduli(shell.sheet, c1, nu * c1)
    modulus = e / (2 * (1 + nu))
    assert q[3] == pytest.approx(modulus)
    entries = dict(shell.plate_stiffness(q, (modulus, modulus, 0.0), shell.thickness).entries)
    for place in ((6, 6), (7, 7)):
        assert entries[place] == pytest.approx(np.full(shell.space.mesh.cells, 5 / 6 * modulus * H))
