import numpy as np
import pytest

from analysis.focusing.grid import Grid


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
