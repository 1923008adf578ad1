"""The rule over a disc against exact means of polynomials."""

import numpy as np
import pytest

from analysis.channel import Footprint
from analysis.declaration.outline import check_disc
from analysis.experiment import Attachment, Plate
from simulation.shell.points import attached_discs, footprint_points


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


@pytest.mark.parametrize(
    "point", [(0.0, 0.1), (0.3, 0.2), (0.3, 0.13), (0.15, 0.0001), (0.12, 0.1), (0.15, 0.0005), (0.05, 0.05)]
)
def test_the_disc_of_a_string_at_the_edge_lies_on_the_plate(point: tuple[float, float]) -> None:
    """Its radius was that of the free space, down to 0, where effects depend on the mesh."""
    hole = {"kind": "circle", "center": (0.1, 0.1), "radius": 0.02}
    plate = Plate(length_x=0.3, length_y=0.2, thickness=0.004, mass=0.23, hole=(hole,))
    (disc,) = attached_discs(plate, [Attachment(point=point)])
    check_disc("disc", disc.point, disc.radius, plate.loop, plate.hole_loops)
    assert 0.001 <= disc.radius <= 0.002
    assert np.hypot(*np.subtract(disc.point, point)) < 0.002
    (declared,) = attached_discs(plate, [Attachment(point=point, radius=0.0002)])
    assert declared.radius == pytest.approx(0.0002)
    assert attached_discs(plate, [Attachment(point=(0.05, 0.05))]) == [Footprint((0.05, 0.05), 0.002)]
