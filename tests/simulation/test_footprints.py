"""The rule over a disc against exact means of polynomials."""

import pytest

from analysis.channel import Footprint
from simulation.shell.footprints import footprint_points


@pytest.mark.parametrize(
    ("power_x", "power_y", "mean"),
    [
        (0, 0, 1.0),
        (2, 0, 1 / 4),
        (0, 2, 1 / 4),
        (4, 0, 1 / 8),
        (2, 2, 1 / 24),
        (1, 0, 0.0),
        (3, 2, 0.0),
        (0, 5, 0.0),
    ],
)
def test_means_of_polynomials_over_a_disc(power_x: int, power_y: int, mean: float) -> None:
    """Mean of x^a y^b over the unit disc, to degree 5."""
    points, average = footprint_points([Footprint((0.3, 0.2), 0.01)])
    x, y = ((points - (0.3, 0.2)) / 0.01).T
    assert average @ (x**power_x * y**power_y) == pytest.approx(mean, abs=1e-12)


def test_a_point_and_nothing() -> None:
    points, average = footprint_points([Footprint((0.3, 0.2), 0.01), Footprint((0.1, 0.1))])
    assert (points.shape, average.shape) == ((8, 2), (2, 8))
    assert average[1] @ points == pytest.approx([0.1, 0.1])
    points, average = footprint_points([])
    assert (points.shape, average.shape) == ((0, 2), (0, 0))
