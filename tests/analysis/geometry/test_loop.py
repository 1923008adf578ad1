import numpy as np
import pytest

from analysis.geometry import loop
from analysis.geometry.loop import Arc, GeometryError, Loop, Segment

HALF_DISC = Loop((Arc((0.0, 0.0), (0.2, 0.2), 0.0, 0.0, np.pi), Segment((-0.2, 0.0), (0.2, 0.0))))


def test_area_centroid_and_perimeter_of_half_a_disc() -> None:
    assert HALF_DISC.area == pytest.approx(0.5 * np.pi * 0.04, rel=1e-13)
    assert HALF_DISC.centroid == pytest.approx((0.0, 4.0 * 0.2 / (3.0 * np.pi)), abs=1e-14)
    assert HALF_DISC.perimeter == pytest.approx(0.2 * np.pi + 0.4, rel=1e-13)


def test_area_and_centroid_move_with_the_loop() -> None:
    there = HALF_DISC.moved(0.9, (0.3, -0.1))
    x, y = HALF_DISC.centroid
    assert there.area == pytest.approx(HALF_DISC.area, rel=1e-13)
    wanted = (0.3 + x * np.cos(0.9) - y * np.sin(0.9), -0.1 + x * np.sin(0.9) + y * np.cos(0.9))
    assert there.centroid == pytest.approx(wanted, abs=1e-14)


def test_an_open_chain_is_refused_with_both_places() -> None:
    with pytest.raises(GeometryError, match=r"curve 2 ends at \(0\.1, 0\.1\) m, the next one begins") as caught:
        Loop((Segment((0.0, 0.0), (0.1, 0.0)), Segment((0.1, 0.0), (0.1, 0.1)), Segment((0.0, 0.1), (0.0, 0.0))))
    assert caught.value.places == ((0.1, 0.1), (0.0, 0.1))


def test_a_clockwise_chain_is_turned_round() -> None:
    clockwise = loop.polygon([(0.0, 0.0), (0.0, 0.1), (0.2, 0.1), (0.2, 0.0)])
    assert clockwise.turned
    assert clockwise.area == pytest.approx(0.02)
    assert not loop.polygon([(0.0, 0.0), (0.2, 0.0), (0.2, 0.1), (0.0, 0.1)]).turned


def test_what_lies_inside_a_circle_is_told_to_the_micrometre() -> None:
    circle = loop.circle((0.1, 0.2), 0.15)
    angle = np.linspace(0.01, 6.2, 97)
    around = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    assert circle.contains((0.1, 0.2) + (0.15 - 1e-7) * around).all()
    assert not circle.contains((0.1, 0.2) + (0.15 + 1e-7) * around).any()
    assert circle.contains((0.1, 0.2) + (0.15 + 1e-7) * around, within=2e-7).all()
    assert not circle.contains((0.1, 0.2) + 0.3 * around, within=2e-7).any()


def test_what_lies_inside_an_l() -> None:
    ell = loop.polygon([(0, 0), (0.4, 0), (0.4, 0.3), (0.2, 0.3), (0.2, 0.2), (0, 0.2)])
    rng = np.random.default_rng(1)
    points = rng.uniform(-0.1, 0.5, (3000, 2))
    x, y = points.T
    inside = (x > 0) & (x < 0.4) & (y > 0) & (y < 0.3) & ((y < 0.2) | (x > 0.2))
    np.testing.assert_array_equal(ell.contains(points), inside)


def test_bounds_are_those_of_the_curves_and_not_of_chords() -> None:
    ellipse = loop.ellipse((0.1, 0.0), (0.3, 0.1), 0.5)
    half = np.hypot([0.3 * np.cos(0.5), 0.3 * np.sin(0.5)], [0.1 * np.sin(0.5), 0.1 * np.cos(0.5)])
    np.testing.assert_allclose(
        ellipse.bounds, [np.subtract((0.1, 0.0), half), np.add((0.1, 0.0), half)], atol=1e-12
    )


def test_the_nearest_point_lies_on_the_curve_itself() -> None:
    circle = loop.circle((0.0, 0.0), 0.2)
    angle = np.array([0.3, 2.0, 3.9, 5.5])
    around = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    for radius in (0.05, 0.199, 0.35):
        found = circle.nearest(radius * around)
        np.testing.assert_allclose(found.points, 0.2 * around, atol=1e-9)
        np.testing.assert_allclose(found.distance, abs(radius - 0.2), atol=1e-12)
        np.testing.assert_array_equal(found.curve, (angle // (np.pi / 2)).astype(int))
        np.testing.assert_allclose(found.t, angle % (np.pi / 2) / (np.pi / 2), atol=1e-8)


def test_distance_from_a_square() -> None:
    square = loop.rectangle((0.0, 0.0), (0.2, 0.2))
    points = np.array([[0.0, 0.0], [0.3, 0.0], [0.2, 0.2], [0.1, 0.05]])
    np.testing.assert_allclose(square.distance(points), [0.1, 0.2, np.hypot(0.1, 0.1), 0.0], atol=1e-15)
