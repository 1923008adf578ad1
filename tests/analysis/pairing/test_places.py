"""Places offered for sensors that move like no declared point, on shapes of a simply supported plate."""

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.pairing.points import LEAST_RANK, KnownShapes, fitting_places, represented, words
from tests.analysis.pairing.test_points import FREQUENCY, NAMES, ORDERS, X, Y

STEP = 0.025
PLACES = np.stack(np.meshgrid(np.arange(0.0, 1.001, STEP), np.arange(0.0, 1.001, STEP)), axis=-1).reshape(-1, 2)
POINTS = np.column_stack([X, Y])


def shapes(at: NDArray[np.float64], orders: list[tuple[int, int]] = ORDERS) -> NDArray[np.float64]:
    """Return shapes at places (G, 2), each driven as at (0.31, 0.27)."""
    drive = np.array([np.sin(m * np.pi * 0.31) * np.sin(n * np.pi * 0.27) for m, n in orders])
    rows = [np.sin(m * np.pi * at[:, 0]) * np.sin(n * np.pi * at[:, 1]) for m, n in orders]
    return np.asarray(np.array(rows).T * np.sign(drive))


def known(orders: list[tuple[int, int]] = ORDERS) -> KnownShapes:
    return KnownShapes(PLACES, shapes(PLACES, orders), NAMES, POINTS)


@pytest.mark.parametrize("place", [(0.2, 0.5), (0.613, 0.338), (0.88, 0.71), (0.31, 0.94)])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_place_of_a_row_is_found_between_the_places_known(place: tuple[float, float], sign: float) -> None:
    rng = np.random.default_rng(0)
    there = shapes(np.array([place]))[0]
    (found,) = fitting_places(sign * there + 0.03 * rng.normal(size=len(there)), 21, known())
    assert found.point == pytest.approx(place, abs=0.02)
    assert found.away == pytest.approx(np.hypot(*(np.array(found.point) - POINTS[21])))
    assert found.turned == (sign < 0.0)
    assert found.left < 0.15


def test_a_place_where_a_declared_point_stands_is_called_by_its_name() -> None:
    (found,) = fitting_places(shapes(POINTS[[8]])[0], 21, known())
    assert found.near == NAMES[8]
    assert found.said.startswith(f"at {NAMES[8]}'s place, (")
    assert " m away" in found.said


def test_modes_that_are_all_symmetrical_leave_two_places() -> None:
    orders = [(m, n) for m in (1, 3, 5) for n in (1, 2, 3, 4)]
    offered = fitting_places(shapes(np.array([[0.3, 0.2]]), orders)[0], 21, known(orders))
    assert sorted(round(one.point[0], 2) for one in offered) == [0.3, 0.7]
    assert ", or at (" in words(offered)
    both = [(m, n) for m in (1, 3, 5) for n in (1, 3, 5)]  # four places: none is told from the others
    assert fitting_places(shapes(np.array([[0.3, 0.2]]), both)[0], 21, known(both)) == ()


@pytest.mark.parametrize("modes", [5, 6, 8])
def test_rows_of_a_loose_sensor_are_hardly_ever_given_a_place(modes: int) -> None:
    rng = np.random.default_rng(modes)
    here = known(ORDERS[:modes])
    offered = [bool(fitting_places(0.6 * rng.normal(size=modes), 21, here)) for _ in range(200)]
    assert np.mean(offered) < 0.1


def test_few_modes_or_one_mode_many_times_offer_nothing() -> None:
    row = shapes(np.array([[0.2, 0.5]]))[0]
    few = KnownShapes(
        PLACES, np.where(np.arange(len(row)) < LEAST_RANK - 1, shapes(PLACES), np.nan), NAMES, POINTS
    )
    assert fitting_places(row, 21, few) == ()
    again = np.tile(shapes(PLACES)[:, :2], 4)
    assert fitting_places(np.tile(row[:2], 4), 21, KnownShapes(PLACES, again, NAMES, POINTS)) == ()


def test_modes_of_the_twin_are_sums_of_coarse_modes_next_to_them() -> None:
    """Two close modes, turned into each other in the coarse model, whose shapes are of another size and sign."""
    at_points, anywhere = shapes(POINTS), shapes(PLACES)
    turn = np.eye(len(ORDERS))
    turn[1:3, 1:3] = [[0.8, 0.6], [-0.6, 0.8]]
    turn = turn * np.linspace(-3.0, 2.0, len(ORDERS))
    sound = np.ones(len(POINTS), dtype=bool)
    sound[[3, 21]] = False
    computed = at_points.copy()
    computed[21] = 7.0  # what is not sound does not count
    found = represented(FREQUENCY, computed, sound, (FREQUENCY * 1.004, at_points @ turn, anywhere @ turn))
    np.testing.assert_allclose(found, anywhere, atol=1e-9)
    wrong = np.random.default_rng(0).normal(size=at_points.shape)
    assert np.isnan(represented(FREQUENCY, wrong, sound, (FREQUENCY, at_points, anywhere))).all()


def test_values_of_other_shapes_are_refused() -> None:
    with pytest.raises(ValueError, match="places"):
        KnownShapes(PLACES[:3], shapes(PLACES), NAMES, POINTS)
