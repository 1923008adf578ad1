"""The space over a mesh: what it holds exactly, that it is continuous, and that points are found."""

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

from analysis.geometry import loop
from analysis.geometry.relations import TOUCH
from simulation.meshing.mesher import Border, mesh_plate
from simulation.meshing.plate_mesh import CURVE_DEGREE, PlateMesh, edges_of
from simulation.shell.shape_functions import lobatto
from simulation.shell.space import ShapeSpace

STRAIGHT = [
    Border("outline", loop.polygon([(0, 0), (0.2, 0), (0.2, 0.1), (0.1, 0.1), (0.1, 0.2), (0, 0.2)]), "outline"),
    Border("patch", loop.rectangle((0.05, 0.05), (0.02, 0.03), 0.4)),
]
CURVED = [
    Border("outline", loop.circle((0.0, 0.0), 0.1), "outline"),
    Border("hole", loop.ellipse((0.0, 0.01), (0.03, 0.02)), "hole"),
]


def bent_pair() -> PlateMesh:
    """Return a square and a triangle that share a curved edge, the square's other edges straight."""
    points = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [2.0, 0.5]])
    quads, triangles = np.array([[0, 1, 2, 3]]), np.array([[1, 4, 2]])
    edges = edges_of(quads, triangles)
    bow = np.zeros((len(edges), CURVE_DEGREE - 1, 2))
    shared = np.flatnonzero((edges == [1, 2]).all(axis=1))[0]
    bow[shared, :3, 0] = [-0.2, 0.08, 0.03]
    bow[shared, :2, 1] = [0.02, -0.05]
    return PlateMesh(points, quads, triangles, edges, bow, {}, {})


def on_edge(mesh, edge, s):
    a, b = mesh.points[mesh.edges[edge]]
    straight = 0.5 * np.outer(1 - s, a) + 0.5 * np.outer(1 + s, b)
    return straight + lobatto(CURVE_DEGREE, s)[0].T @ mesh.bow[edge]


def projected(space, field):
    """Coefficients of a field, from its moments."""
    return spsolve(space.product("0", "0").tocsc(), space.moments("0", field(space.points)))


@pytest.mark.parametrize("degree", [1, 2, 3, 6])
def test_polynomials_of_the_degree_are_held_exactly_on_straight_cells(degree):
    space = ShapeSpace.on(mesh_plate(STRAIGHT, 0.01), degree)
    inside = space.points[:: len(space.points) // 50]
    for power in range(degree + 1):

        def field(p, power=power):
            return (10 * p[:, 0]) ** power * (10 * p[:, 1]) ** (degree - power)

        found = space.values(inside) @ projected(space, field)
        assert found == pytest.approx(field(inside), abs=1e-9 * 2.0**degree)


def test_one_degree_more_is_not_held():
    space = ShapeSpace.on(mesh_plate(STRAIGHT, 0.01), 2)

    def cubic(p):
        return (10 * p[:, 0]) ** 3

    miss = space.values(space.points[::7]) @ projected(space, cubic) - cubic(space.points[::7])
    assert np.abs(miss).max() > 1e-4


@pytest.mark.parametrize("borders", [STRAIGHT, CURVED])
def test_functions_of_points_add_up_to_one(borders):
    space = ShapeSpace.on(mesh_plate(borders, 0.005), 4)
    one = np.zeros(space.size)
    one[: len(space.mesh.points)] = 1.0
    assert space.values(space.points[::11]) @ one == pytest.approx(1.0, abs=1e-12)
    by_x, by_y = space.slopes(space.points[::11])
    assert by_x @ one == pytest.approx(0.0, abs=1e-9)
    assert by_y @ one == pytest.approx(0.0, abs=1e-9)


def test_a_smooth_field_is_approached_with_the_degree_on_curved_cells():
    mesh = mesh_plate(CURVED, 0.005)

    def field(p):
        return np.sin(30 * p[:, 0]) * np.exp(10 * p[:, 1])

    misses = []
    for degree in (2, 4, 6):
        space = ShapeSpace.on(mesh, degree)
        at = ShapeSpace.on(mesh, 3).points[::5]
        misses.append(np.abs(space.values(at) @ projected(space, field) - field(at)).max())
    assert misses[1] < 0.1 * misses[0]
    assert misses[2] < 0.1 * misses[1]


@pytest.mark.parametrize("degree", [2, 5, 8])
def test_functions_are_continuous_across_a_curved_edge_of_two_kinds_of_cells(degree):
    mesh = bent_pair()
    space = ShapeSpace.on(mesh, degree)
    edge = np.flatnonzero((mesh.edges == [1, 2]).all(axis=1))[0]
    s = np.linspace(-0.95, 0.95, 15)
    places = on_edge(mesh, edge, s)
    tilt = np.gradient(places, axis=0)
    across = np.stack([tilt[:, 1], -tilt[:, 0]], axis=1) / np.hypot(*tilt.T)[:, None]
    # 1e-6 to each side lies in another cell; what changes there is of that order unless a function jumps.
    sides = [space.values(places + way * 1e-6 * across).toarray() for way in (-1.0, 1.0)]
    cells = [space.locate(places + way * 1e-6 * across)[0] for way in (-1.0, 1.0)]
    assert (cells[0] == 0).all()
    assert (cells[1] == 1).all()
    assert np.abs(sides[0] - sides[1]).max() < 1e-4
    own = space.edge_functions(np.array([edge]))[0]
    assert sides[0][:, own] == pytest.approx(lobatto(degree, s)[0].T, abs=1e-4)


def test_areas_and_moments_of_a_disc():
    space = ShapeSpace.on(mesh_plate([Border("outline", loop.circle((0.02, -0.01), 0.1), "outline")], 0.005), 4)
    x, y = (space.points - [0.02, -0.01]).T
    area = np.pi * 0.1**2
    assert space.dx.sum() == pytest.approx(area, rel=1e-10)
    assert space.dx @ x**2 == pytest.approx(area * 0.1**2 / 4.0, rel=1e-9)
    assert space.dx @ (x * y) == pytest.approx(0.0, abs=1e-12 * area)


def test_integrals_of_slopes_are_those_of_the_field():
    space = ShapeSpace.on(mesh_plate(CURVED, 0.005), 6)

    def field(p):
        return np.sin(20 * p[:, 0]) * np.cos(15 * p[:, 1])

    c = projected(space, field)
    x, y = space.points.T
    by_x = 20 * np.cos(20 * x) * np.cos(15 * y)
    by_y = -15 * np.sin(20 * x) * np.sin(15 * y)
    f = field(space.points)
    parts = {"x": by_x, "y": by_y, "0": f}
    for row, column in ("xx", "yy", "xy", "x0", "y0", "00"):
        found = c @ space.product(row, column) @ c
        assert found == pytest.approx(space.dx @ (parts[row] * parts[column]), rel=1e-5, abs=1e-8)


def test_slopes_are_differences_of_values():
    space = ShapeSpace.on(mesh_plate(CURVED, 0.005), 5)
    at = space.points[::41]
    slopes = space.slopes(at)
    for axis, slope in enumerate(slopes):
        step = np.eye(2)[axis] * 1e-8
        difference = (space.values(at + step) - space.values(at - step)).toarray() / 2e-8
        assert slope.toarray() == pytest.approx(difference, abs=1e-5 * np.abs(slope).max())


@pytest.mark.parametrize("borders", [STRAIGHT, CURVED])
def test_every_point_is_found_in_its_cell(borders):
    space = ShapeSpace.on(mesh_plate(borders, 0.005), 3)
    cell, _ = space.locate(space.points)
    each = [np.repeat(np.arange(len(g.dx)), g.dx.shape[1]) for g in space.groups]
    assert (cell == np.concatenate([each[0], len(space.mesh.quads) + each[1]])).all()


@pytest.mark.parametrize("borders", [STRAIGHT, CURVED])
def test_points_on_edges_and_corners_are_found(borders):
    mesh = mesh_plate(borders, 0.005)
    space = ShapeSpace.on(mesh, 3)
    points = np.vstack([mesh.points, *(on_edge(mesh, k, np.array([-0.3, 0.6])) for k in range(len(mesh.edges)))])
    geometry = np.zeros((space.size, 2))
    geometry[: len(mesh.points)] = mesh.points
    cell, local = space.locate(points)
    assert (cell >= 0).all()
    corners = space.values(mesh.points)[:, : len(mesh.points)]
    assert np.abs(corners - np.eye(len(mesh.points))).max() < 1e-8
    assert np.abs(local).max() < 1.0 + 1e-3


@pytest.mark.parametrize("borders", [STRAIGHT, CURVED])
def test_points_that_touch_the_plate_are_on_it(borders):
    """The declaration counts them as such; strips along edges are thin."""
    space = ShapeSpace.on(mesh_plate(borders, 0.0008), 3)
    edge = next(border.loop for border in borders if border.kind == "outline")
    middle, along = edge.over_sides(np.arange(len(edge.polygon)), np.full(len(edge.polygon), 0.47))
    outward = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.hypot(*along.T)[:, None]
    near = middle + 0.9 * TOUCH * outward
    assert (space.locate(near)[0] >= 0).all()
    assert np.abs(space.values(near) - space.values(middle)).max() < 5e-3
    with pytest.raises(ValueError, match="off the plate"):
        space.locate(middle + 20.0 * TOUCH * outward)


def test_points_off_the_plate_are_refused_with_the_place():
    space = ShapeSpace.on(mesh_plate(CURVED, 0.005), 3)
    for place in ((0.0, 0.01), (0.1005, 0.0)):
        with pytest.raises(ValueError, match=f"{place[0]:g}, {place[1]:g}"):
            space.values(np.array([place]))


def test_a_cell_turned_over_is_refused_with_the_place():
    mesh = bent_pair()
    mesh.points[4] = [0.5, 0.5]
    with pytest.raises(ValueError, match=r"near \(0.83333, 0.5\) m is turned over"):
        ShapeSpace.on(mesh, 3)


def test_weights_and_parts_add_up():
    space = ShapeSpace.on(mesh_plate(STRAIGHT, 0.01), 3)
    part = space.mesh.inside["patch"]
    whole = space.product("x", "0")
    two = space.product("x", "0", part) + space.product("x", "0", ~part)
    assert np.abs(whole - two).max() < 1e-12 * np.abs(whole).max()
    weighted = space.product("x", "0", weight=np.where(space.spread(part), 3.0, 1.0))
    assert np.abs(weighted - (two + 2.0 * space.product("x", "0", part))).max() < 1e-12 * np.abs(whole).max()
