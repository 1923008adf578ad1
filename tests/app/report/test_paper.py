"""Which plates are set beside the paper's."""

import numpy as np
import pytest

from analysis.declaration.plate import Plate
from analysis.focusing.methods import MethodComparison
from app.report.paper import is_the_papers, method_rows


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


@pytest.mark.parametrize(("highest", "rows"), [(300.0, 3), (200.0, 2), (800.0, 4)])
def test_the_paper_is_compared_where_the_panel_s_band_goes(highest: float, rows: int) -> None:
    frequency = np.arange(100.0, highest + 1.0, 10.0)
    ones = np.ones((1, len(frequency)))
    found = method_rows(MethodComparison(("stif",), (1.1e9, 0.33, 0.06), frequency, ones, ones))
    assert len(found) == rows
    headings = " ".join(row.quantity for row in found)
    assert (f"to {min(540.0, highest):.0f} Hz" in headings, "to 540 Hz" in headings) == (True, highest > 540.0)
    assert all(row.ours in ("1.00 mean", "100 mean") for row in found)
