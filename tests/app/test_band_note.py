"""What `compensate` says about the uncertainty of the laws."""

import numpy as np

from analysis.compensation.law_band import ContrastBand
from app.summaries.compensation import band_note

TEMPERATURE, ENDS = np.array([0.0, 40.0]), np.array([[0.7, 0.71], [0.6, 0.64]])


def band(outside: np.ndarray | None) -> ContrastBand:
    return ContrastBand(TEMPERATURE, ENDS, ENDS, ENDS, 0.9, 2000, outside)


def test_draws_outside_the_twin_are_said_with_the_way_out() -> None:
    told = band_note(band(np.array([0.02, 0.31])))
    assert "31% of the plates drawn at 40 °C lie outside the box of the panel's twin" in told
    assert told.endswith("widen [twin] in the panel's file to compute them")


def test_nothing_is_said_of_draws_where_all_lie_inside_or_nobody_looked() -> None:
    inside = band_note(band(np.zeros(2)))
    assert inside == band_note(band(None))
    assert inside.endswith("(0.6000 to 0.6400 at 40 °C)")
