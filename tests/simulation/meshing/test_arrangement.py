import numpy as np
import pytest

from analysis.geometry import loop
from analysis.geometry.loop import GeometryError
from simulation.meshing.arrangement import Arrangement

SQUARE = loop.rectangle((0.0, 0.0), (0.2, 0.2))


def sorted_faces(plan):
    return sorted((len(face.cycles), sorted(face.inside)) for face in plan.faces)


def test_a_patch_away_from_the_edge_makes_two_faces():
    plan = Arrangement.of([SQUARE, loop.circle((0.02, 0.01), 0.02)])
    assert sorted_faces(plan) == [(1, [0, 1]), (2, [0])]
    assert len(plan.edges) == 8


def test_crossing_rectangles_make_a_face_of_each_part():
    plan = Arrangement.of(
        [SQUARE, loop.rectangle((0, 0), (0.04, 0.04)), loop.rectangle((0.02, 0.02), (0.04, 0.04))]
    )
    assert sorted(sorted(face.inside) for face in plan.faces) == [[0], [0, 1], [0, 1, 2], [0, 2]]
    crossed = plan.nodes[(np.abs(plan.nodes) < 0.0201).all(axis=1)]
    assert sorted(map(tuple, crossed.round(9).tolist()))[1:-1] == [
        (-0.02, 0.02),
        (0.0, 0.0),
        (0.0, 0.02),
        (0.02, -0.02),
        (0.02, 0.0),
    ]


def test_circles_cross_where_the_chord_says():
    plan = Arrangement.of([SQUARE, loop.circle((-0.01, 0.0), 0.03), loop.circle((0.01, 0.0), 0.03)])
    half_chord = np.sqrt(0.03**2 - 0.01**2)
    for sign in (1.0, -1.0):
        away = np.hypot(*(plan.nodes - [0.0, sign * half_chord]).T)
        assert away.min() < 1e-12
    assert len(plan.faces) == 4


@pytest.mark.parametrize("loop", [loop.rectangle((0.01, 0.02), (0.03, 0.02), 0.3), loop.circle((0.0, 0.01), 0.02)])
def test_borders_on_each_other_are_one_line(loop):
    plan = Arrangement.of([SQUARE, loop, loop])
    assert sorted(sorted(face.inside) for face in plan.faces) == [[0], [0, 1, 2]]
    assert sorted(len(edge.origins) for edge in plan.edges) == [1] * 4 + [2] * 4


def test_a_patch_flush_with_the_edge_shares_a_part_of_it():
    plan = Arrangement.of([SQUARE, loop.rectangle((0.0, -0.09), (0.04, 0.02))])
    (shared,) = (edge for edge in plan.edges if len(edge.origins) == 2)
    assert np.sort(shared.curve.at([0.0, 1.0])[:, 0]) == pytest.approx([-0.02, 0.02])
    assert {origin.border for origin in shared.origins} == {0, 1}
    whole = next(origin for origin in shared.origins if origin.border == 0)
    assert sorted((whole.first, whole.last)) == pytest.approx([0.4, 0.6])


def test_patches_side_by_side_share_a_line():
    plan = Arrangement.of([SQUARE, loop.rectangle((0, 0), (0.04, 0.04)), loop.rectangle((0.03, 0), (0.02, 0.02))])
    assert [len(edge.origins) for edge in plan.edges].count(2) == 1
    assert sorted(sorted(face.inside) for face in plan.faces) == [[0], [0, 1], [0, 2]]


def test_extra_nodes_cut_the_border_they_lie_on():
    plan = Arrangement.of([SQUARE], [(0.03, -0.1), (0.0, 0.0)])
    assert len(plan.edges) == 5
    assert np.hypot(*(plan.nodes - [0.03, -0.1]).T).min() < 1e-12


def test_half_edges_run_with_the_face_on_their_left():
    plan = Arrangement.of([SQUARE, loop.circle((0.0, 0.0), 0.02)])
    t = np.linspace(0.0, 1.0, 200)
    areas = []
    for face in plan.faces:
        around = [np.vstack([plan.curve(half).at(t)[:-1] for half in cycle]) for cycle in face.cycles]
        areas.append(sum(0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1)) for x, y in (a.T for a in around)))
    circle = np.pi * 0.02**2
    assert sorted(areas) == pytest.approx([circle, 0.04 - circle], rel=1e-4)


def test_a_round_patch_that_touches_the_edge_is_refused_with_its_place():
    with pytest.raises(GeometryError, match="touch without crossing") as caught:
        Arrangement.of([SQUARE, loop.circle((0.0, -0.08), 0.02)])
    assert caught.value.places[0] == pytest.approx((0.0, -0.1), abs=1e-6)
