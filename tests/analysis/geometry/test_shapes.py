import numpy as np
import pytest

from analysis.geometry import loop


def test_areas_are_those_of_the_closed_forms() -> None:
    assert loop.rectangle((0.3, 0.1), (0.24, 0.19), 0.7).area == pytest.approx(0.24 * 0.19, rel=1e-12)
    assert loop.circle((0.3, 0.1), 0.15).area == pytest.approx(np.pi * 0.15**2, rel=1e-12)
    assert loop.ellipse((0.3, 0.1), (0.2, 0.05), 0.7).area == pytest.approx(np.pi * 0.2 * 0.05, rel=1e-12)
    triangle = loop.polygon([(0.0, 0.0), (0.3, 0.1), (0.1, 0.4)])
    assert triangle.area == pytest.approx(0.5 * (0.3 * 0.4 - 0.1 * 0.1), rel=1e-12)
    assert triangle.centroid == pytest.approx((0.4 / 3.0, 0.5 / 3.0), rel=1e-12)


def test_centres_are_centroids() -> None:
    for shape in (
        loop.rectangle((0.3, 0.1), (0.24, 0.19), 0.7),
        loop.circle((0.3, 0.1), 0.15),
        loop.ellipse((0.3, 0.1), (0.2, 0.05), 0.7),
    ):
        assert shape.centroid == pytest.approx((0.3, 0.1), abs=1e-13)


def test_the_curves_of_a_rectangle_are_bottom_right_top_left() -> None:
    middles = [curve.at(0.5) for curve in loop.rectangle((0.1, 0.05), (0.2, 0.1)).curves]
    np.testing.assert_allclose(middles, [(0.1, 0.0), (0.2, 0.05), (0.1, 0.1), (0.0, 0.05)], atol=1e-15)


def test_a_closed_spline_converges_to_the_circle_it_runs_through() -> None:
    """A periodic cubic spline errs by the fourth power of its spacing."""
    errors = []
    for count in (8, 16, 32):
        angle = 2.0 * np.pi * np.arange(count) / count
        errors.append(
            abs(loop.closed_spline(0.1 * np.stack([np.cos(angle), np.sin(angle)], 1)).area / np.pi - 0.01)
        )
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (orders > 3.7).all()
    assert errors[-1] < 1e-6


def test_too_few_points_are_refused() -> None:
    with pytest.raises(ValueError, match="polygon of 2 points"):
        loop.polygon([(0.0, 0.0), (1.0, 0.0)])
    with pytest.raises(ValueError, match="at least 4 points"):
        loop.closed_spline([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)])
    with pytest.raises(ValueError, match="same point twice"):
        loop.closed_spline([(0.0, 0.0), (1.0, 0.0), (1.0, 0.0), (0.0, 1.0)])
