import numpy as np
import pytest

from analysis.focusing.energy import Grid
from analysis.focusing.panel import Panel, Target


@pytest.mark.parametrize("cells", [(40, 30), (37, 23), (11, 7)])
def test_the_target_keeps_its_area_and_centre_on_any_grid(supported, cells):
    grid = Grid.of(supported.panel.model_copy(update={"grid": cells}))
    assert len(grid.area) == cells[0] * cells[1]
    assert grid.area.sum() == pytest.approx(0.24 * 0.19)
    assert grid.target_share == pytest.approx(0.25 * 0.3)
    assert grid.target.max() == 1.0


def test_target_cells_lie_in_the_declared_rectangle(supported):
    grid = supported.grid
    inside = grid.points[grid.target > 0.0] / np.array([0.24, 0.19])
    assert set(np.unique(grid.target)) == {0.0, 1.0}
    assert inside.mean(axis=0) == pytest.approx((0.3, 0.55))
    assert np.ptp(inside, axis=0) == pytest.approx((0.25 - 1 / 40, 0.3 - 1 / 30))


def test_arrays_of_other_lengths_are_refused(supported):
    grid = supported.grid
    with pytest.raises(ValueError, match=r"must be \(K, 2\)"):
        Grid(grid.points[:-1], grid.area, grid.target, grid.length, grid.center)
    with pytest.raises(ValueError, match="covers no cell"):
        Grid(grid.points, grid.area, 0.0 * grid.target, grid.length, grid.center)


def disc_with_a_hole(cells=(40, 40), **target):
    return Panel.model_validate(
        {
            "title": "disc",
            "plate": {
                "outline": {"kind": "circle", "center": (0.1, -0.2), "radius": 0.15},
                "hole": ({"kind": "circle", "center": (0.17, -0.2), "radius": 0.03},),
                "thickness": 0.003,
                "mass": 0.2,
            },
            "patch": (
                {"id": "A1", "role": "actuator", "center": (0.1, -0.3), "diameter": 0.02, "thickness": 5e-4},
            ),
            "target": {"center": (0.35, 0.5), "size": (0.2, 0.3)} | target,
            "grid": cells,
        }
    )


@pytest.mark.parametrize("cells", [(40, 40), (23, 37)])
def test_cells_off_any_plate_are_left_out_and_their_areas_are_those_on_it(cells):
    panel = disc_with_a_hole(cells)
    grid = Grid.of(panel)
    assert panel.plate.contains(grid.points).all()
    assert len(grid.points) < 0.8 * cells[0] * cells[1]
    assert grid.area.sum() == pytest.approx(np.pi * (0.15**2 - 0.03**2), rel=1e-12)
    assert grid.area @ grid.target == pytest.approx(0.06 * 0.09, rel=0.01)
    assert grid.center == pytest.approx((0.1 - 0.15 * 0.3, -0.2))
    assert grid.length == pytest.approx((0.3, 0.3))


def test_integrals_over_any_plate_converge_to_the_closed_form():
    """The mean of r squared over the disc less that over the hole, by the parallel-axis theorem."""
    disc, hole = np.pi * 0.15**4 / 2, np.pi * 0.03**2 * (0.03**2 / 2 + 0.07**2)
    errors = []
    for count in (10, 40):
        grid = Grid.of(disc_with_a_hole((count, count)))
        away = grid.points - (0.1, -0.2)
        errors.append(abs(grid.area @ (away**2).sum(axis=1) / (disc - hole) - 1.0))
    assert errors[1] < 0.005
    assert errors[1] < errors[0]


@pytest.mark.parametrize(
    ("target", "area", "center"),
    [
        ({"center": (0.4, 0.5), "size": (0.3, 0.4), "shape": "ellipse"}, np.pi / 4 * 0.3 * 0.4, (0.4, 0.5)),
        ({"center": (0.4, 0.5), "size": (0.3, 0.2), "angle": 30.0}, 0.3 * 0.2, (0.4, 0.5)),
        ({"polygon": ((0.2, 0.2), (0.8, 0.2), (0.5, 0.8))}, 0.18, (0.5, 0.4)),
        (
            {"spot": ({"center": (0.2, 0.5), "size": (0.2, 0.3)}, {"center": (0.8, 0.5), "size": (0.2, 0.3)})},
            0.12,
            (0.5, 0.5),
        ),
    ],
)
def test_targets_of_any_form_keep_their_area_and_centre(supported, target, area, center):
    panel = supported.panel.model_copy(update={"target": Target.model_validate(target)})
    grid = Grid.of(panel)
    assert grid.target_share == pytest.approx(area, rel=5e-3)
    weight = grid.area * grid.target
    assert (weight @ grid.points) / weight.sum() / (0.24, 0.19) == pytest.approx(center, abs=2e-3)
    assert len(grid.centers) == len(panel.target.spots)


def test_two_half_rectangles_aim_at_what_the_whole_one_aims_at(supported):
    """Two spots side by side are one target; the whole one's share of a cell is exact."""
    halves = tuple({"center": (x, 0.55), "size": (0.125, 0.3)} for x in (0.2375, 0.3625))
    pair = supported.panel.model_copy(update={"target": Target.model_validate({"spot": halves})})
    np.testing.assert_allclose(Grid.of(pair).target, supported.grid.target, atol=1e-12)
