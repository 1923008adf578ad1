import numpy as np

from analysis.drawn_curves import in_lines


def test_points_without_a_neighbour_are_left_out() -> None:
    gap = np.nan
    tracks = np.array([[1.0, 5.0, gap], [2.0, gap, 7.0], [gap, 6.0, 8.0], [9.0, 6.0, gap]])
    expected = np.array([[1.0, gap, gap], [2.0, gap, 7.0], [gap, 6.0, 8.0], [gap, 6.0, gap]])
    np.testing.assert_array_equal(in_lines(tracks), expected)
    assert not np.isfinite(in_lines(np.array([[4.0]]))).any()
