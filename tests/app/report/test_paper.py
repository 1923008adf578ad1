"""Which plates are set beside the paper's."""

import pytest

from analysis.plate import Plate
from app.report.paper import is_the_papers


@pytest.mark.parametrize(
    ("size", "mass", "same"),
    [
        ((0.24, 0.19, 0.003), 0.12996, True),
        ((0.24, 0.19, 0.003), 0.33, False),
        ((0.3, 0.2, 0.002), 0.13, False),
    ],
)
def test_only_a_plate_of_its_size_and_mass_is_compared(
    size: tuple[float, float, float], mass: float, same: bool
) -> None:
    length_x, length_y, thickness = size
    assert is_the_papers(Plate(length_x=length_x, length_y=length_y, thickness=thickness, mass=mass)) is same
