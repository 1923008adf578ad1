"""Meshes of plates: areas, conformity, borders that are followed, cells that are sound."""

import numpy as np
import pytest

from analysis.geometry import loop
from analysis.geometry.loop import GeometryError
from simulation.meshing.arrangement import Arrangement
from simulation.meshing.mesher import Border, jacobian_ratio, mesh_plate
from simulation.meshing.plate_mesh import CURVE_DEGREE, MeshRecipe
from simulation.shell.shape_functions import lobatto
from simulation.shell.space import ShapeSpace

OUTLINE = Border("outline", loop.rectangle((0.12, 0.095), (0.24, 0.19)), "outline")
ANGLES = np.arange(12) * 2.0 * np.pi / 12.0
BLOB = np.stack([0.2 * np.cos(ANGLES) * (1 + 0.2 * np.cos(3 * ANGLES)), 0.15 * np.sin(ANGLES)], axis=1)
PLATES = {
    "paper": [
        OUTLINE,
        Border("A1", loop.rectangle((0.2, 0.155), (0.02, 0.02))),
        Border("S1", loop.rectangle((0.04, 0.035), (0.02, 0.02))),
    ],
    "flush": [
        OUTLINE,
        Border("A1", loop.rectangle((0.01, 0.095), (0.02, 0.02))),
        Border("A2", loop.rectangle((0.01, 0.01), (0.02, 0.02))),
    ],
    "both faces": [
        OUTLINE,
        Border("A1", loop.rectangle((0.1, 0.1), (0.02, 0.02))),
        Border("A2", loop.rectangle((0.105, 0.112), (0.02, 0.02), 0.4)),
        Border("B1", loop.circle((0.2, 0.05), 0.01)),
        Border("B2", loop.circle((0.2, 0.05), 0.01)),
    ],
    "annulus": [
        Border("outline", loop.circle((0.0, 0.0), 0.1), "outline"),
        Border("hole 1", loop.circle((0.0, 0.0), 0.03), "hole"),
    ],
    "trim": [
        Border("outline", loop.polygon([(0, 0), (0.4, 0), (0.4, 0.2), (0.3, 0.3), (0, 0.25)]), "outline"),
        Border("hole 1", loop.ellipse((0.12, 0.12), (0.05, 0.03), 0.4), "hole"),
        Border("p1", loop.rectangle((0.3, 0.1), (0.03, 0.02), 0.5)),
        Border("p2", loop.circle((0.25, 0.22), 0.0125)),
    ],
    "blob": [
        Border("outline", loop.closed_spline(BLOB), "outline"),
        Border("p1", loop.rectangle((0.1, 0.02), (0.03, 0.02), 0.5)),
    ],
    "close patches": [
        Border("outline", loop.polygon([(0, 0), (0.2, 0), (0.05, 0.15)]), "outline"),
        Border("A1", loop.rectangle((0.05, 0.02), (0.02, 0.02))),
        Border("A2", loop.rectangle((0.079, 0.02), (0.02, 0.02), 0.1)),
        Border("A3", loop.circle((0.05, 0.05), 0.01)),
    ],
    "sharp corner": [
        Border("outline", loop.polygon([(0, 0), (0.3, 0), (0.3, 0.3 * np.tan(np.deg2rad(20)))]), "outline")
    ],
    "narrow gap": [
        Border("outline", loop.rectangle((0.1, 0.05), (0.2, 0.1)), "outline"),
        Border("slit", loop.rectangle((0.1, 0.0035), (0.06, 0.004)), "hole"),
    ],
    "slender hole": [
        Border("outline", loop.circle((0.0, 0.0), 0.1), "outline"),
        Border("slit", loop.ellipse((0.0, 0.0), (0.08, 0.002)), "hole"),
    ],
}  # fmt: skip

FINER = MeshRecipe(spacing=0.034, strip=0.7, edge_strip=0.85, growth=1.1)


def on_edges(mesh, edges, count=9):
    """Points along mesh edges, (K, count, 2)."""
    s = np.linspace(-1.0, 1.0, count)
    ends = mesh.points[mesh.edges[edges]]
    straight = 0.5 * (1 - s)[:, None] * ends[:, :1] + 0.5 * (1 + s)[:, None] * ends[:, 1:]
    return straight + np.einsum("cs,kcd->ksd", lobatto(CURVE_DEGREE, s)[0], mesh.bow[edges])


def check(borders, mesh):
    """Hold a mesh against what every mesh has to meet."""
    space = ShapeSpace.on(mesh, 2)
    loops = {border.name: border.loop for border in borders}
    sign = {"outline": 1.0, "hole": -1.0, "inner": 0.0}
    assert space.dx.sum() == pytest.approx(sum(sign[b.kind] * b.loop.area for b in borders), rel=1e-10)
    assert jacobian_ratio(mesh).min() > 0.01
    users = np.bincount(np.concatenate([mesh.quad_edges.ravel(), mesh.triangle_edges.ravel()]))
    assert users.size == len(mesh.edges)
    assert set(users) <= {1, 2}
    rim = np.unique(np.concatenate([mesh.borders[b.name].edge for b in borders if b.kind != "inner"]))
    assert np.flatnonzero(users == 1) == pytest.approx(rim)
    for border in borders:
        own = mesh.borders[border.name]
        points = on_edges(mesh, own.edge)
        assert border.loop.nearest(points.reshape(-1, 2)).distance.max() < 1e-8
        for k in range(len(own.edge)):
            ends = loops[border.name].curves[own.curve[k]].at(own.span[k])
            assert points[k, [0, -1]] == pytest.approx(ends, abs=1e-9)
        length = np.hypot(*np.diff(on_edges(mesh, own.edge, 200), axis=1).transpose(2, 0, 1)).sum()
        assert length == pytest.approx(border.loop.perimeter, rel=1e-4)
        if border.kind == "inner":
            inside = space.spread(mesh.inside[border.name])
            assert space.dx[inside].sum() == pytest.approx(border.loop.area, rel=1e-10)
            assert border.loop.contains(space.points[inside], within=1e-9).all()
            assert not border.loop.contains(space.points[~inside]).any()


@pytest.mark.parametrize("thickness", [0.001, 0.003, 0.006])
@pytest.mark.parametrize("name", PLATES)
def test_meshes_are_conforming_and_follow_their_borders(name, thickness):
    check(PLATES[name], mesh_plate(PLATES[name], thickness))


def test_cells_beside_a_border_are_a_strip_of_the_width_asked_for():
    mesh = mesh_plate([OUTLINE], 0.003, MeshRecipe(edge_strip=0.8))
    quads = mesh.points[mesh.quads]
    away = np.minimum.reduce([quads[..., 0], 0.24 - quads[..., 0], quads[..., 1], 0.19 - quads[..., 1]])
    assert away.max() == pytest.approx(0.8 * 0.003)
    assert ((away < 1e-12).sum(axis=1) >= 2).all()


def test_cells_shrink_towards_corners_of_patches():
    borders = PLATES["paper"]
    coarse, fine = (mesh_plate(borders, 0.003, MeshRecipe(grading=share)) for share in (0.0, 0.3))
    corner = borders[1].loop.curves[0].at(0.0)

    def shortest(mesh):
        ends = mesh.points[mesh.edges]
        at_corner = (np.hypot(*(ends - corner).transpose(2, 0, 1)) < 1e-12).any(axis=1)
        return np.hypot(*(ends[at_corner, 1] - ends[at_corner, 0]).T)

    assert shortest(fine) == pytest.approx(0.3 * shortest(coarse))


@pytest.mark.parametrize("levels", [0, 1, 3])
def test_corners_of_the_outline_are_graded_where_asked(levels):
    mesh = mesh_plate([OUTLINE], 0.003, MeshRecipe(grading=0.2, levels=levels, outer_corners=True))
    check([OUTLINE], mesh)
    ends = mesh.points[mesh.edges]
    at_corner = (np.hypot(*ends.transpose(2, 0, 1)) < 1e-12).any(axis=1)
    assert np.hypot(*(ends[at_corner, 1] - ends[at_corner, 0]).T) == pytest.approx(0.2**levels * 0.003)


def test_strips_end_where_there_is_no_room_and_go_on_elsewhere():
    hole = Border("hole", loop.rectangle((0.12, 0.0053), (0.02, 0.01), 0.001), "hole")
    mesh = mesh_plate([OUTLINE, hole], 0.006)
    check([OUTLINE, hole], mesh)
    own = mesh.borders["outline"].edge
    middle = mesh.points[mesh.edges[own]].mean(axis=1)
    bare = ~np.isin(own, mesh.quad_edges)
    assert bare.any()
    assert (np.hypot(*(middle[bare] - [0.12, 0.0]).T) < 0.03).all()


def test_borders_that_nearly_coincide_are_refused_with_their_place():
    hole = Border("hole", loop.rectangle((0.12, 0.005 + 3e-6), (0.02, 0.01)), "hole")
    patch = Border("patch 1", loop.rectangle((0.12, 0.15), (0.02, 0.02)))
    with pytest.raises(GeometryError, match=r"outline and hole|hole and outline") as caught:
        mesh_plate([OUTLINE, patch, hole], 0.003)
    assert "too close to each other" in str(caught.value)
    x, y = caught.value.places[0]
    assert 0.109 < x < 0.131
    assert y < 1e-4


def across(seed):
    """Plate 0.2 x 0.15 m with two turned rectangles that overlap in part, as patches on both faces may."""
    rng = np.random.default_rng(seed)
    center = np.array([rng.uniform(0.05, 0.15), rng.uniform(0.05, 0.1)])
    both = [center, center + rng.uniform(-0.02, 0.02, 2)]
    loops = [loop.rectangle(c, rng.uniform(0.012, 0.045, 2), float(rng.uniform(-1.57, 1.57))) for c in both]
    patches = [Border(f"patch {k + 1}", loop) for k, loop in enumerate(loops)]
    return [Border("outline", loop.rectangle((0.1, 0.075), (0.2, 0.15)), "outline"), *patches]


@pytest.mark.parametrize("recipe", [None, FINER])
def test_a_turned_patch_partly_over_another_one_is_meshed(recipe):
    borders = across(0)[:1]
    borders += [Border("A", loop.rectangle((0.08, 0.07), (0.04, 0.03)))]
    borders += [Border("S", loop.rectangle((0.1, 0.08), (0.03, 0.03), np.deg2rad(30.0)))]
    check(borders, mesh_plate(borders, 0.004, recipe))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(60))
def test_patches_drawn_across_each_other_are_meshed(seed):
    borders = across(seed)
    check(borders, mesh_plate(borders, 0.004, None if seed % 2 else FINER))


def test_patches_turned_by_next_to_nothing_are_refused_by_name():
    plate, first, second = across(0)[0], (0.04, 0.03), np.deg2rad(0.05)
    patches = [Border("A", loop.rectangle((0.08, 0.07), first))]
    patches += [Border("S", loop.rectangle((0.09, 0.07), first, second))]
    with pytest.raises(GeometryError, match=r"^(A and S|S and A): two borders touch without crossing") as caught:
        mesh_plate([plate, *patches], 0.004)
    assert len(caught.value.places) == 1


def test_a_narrower_spacing_makes_smaller_cells():
    sizes = []
    for spacing in (0.04, 0.02):
        mesh = mesh_plate(PLATES["paper"], 0.003, MeshRecipe(spacing=spacing))
        corners = mesh.points[mesh.triangles]
        sizes.append(np.hypot(*(corners - np.roll(corners, 1, axis=1)).transpose(2, 0, 1)).max())
    assert sizes[1] < 0.7 * sizes[0]
    assert sizes[0] < 1.6 * 0.04


def test_cuts_end_edges_where_a_support_ends():
    mesh = mesh_plate([OUTLINE], 0.003, cuts=[(0.05, 0.0)])
    assert np.hypot(*(mesh.points - [0.05, 0.0]).T).min() < 1e-12


@pytest.mark.parametrize("seed", range(20))
def test_plates_drawn_by_chance_are_meshed(random_plate, seed):
    borders, thickness = random_plate(seed)
    mesh = mesh_plate(borders, thickness)
    check(borders, mesh)
    net = sum({"outline": 1.0, "hole": -1.0, "inner": 0.0}[b.kind] * b.loop.area for b in borders)
    assert mesh.cells < 700 + 4.0 * net / MeshRecipe().bulk(thickness) ** 2


def narrowest(borders):
    """Smallest distance between a corner or crossing of borders and another part of them, m."""
    plan, t = Arrangement.of([border.loop for border in borders]), np.linspace(0.0, 1.0, 500)
    return min(
        np.hypot(*(edge.curve.at(t) - node).T).min()
        for edge in plan.edges
        for k, node in enumerate(plan.nodes)
        if k not in (edge.start, edge.end)
    )


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20, 200))
def test_many_plates_drawn_by_chance_are_meshed(random_plate, seed):
    borders, thickness = random_plate(seed)
    try:
        mesh = mesh_plate(borders, thickness)
    except GeometryError:
        if narrowest(borders) > 1e-4:  # nothing but borders that nearly coincide may be refused
            raise
        return
    check(borders, mesh)
