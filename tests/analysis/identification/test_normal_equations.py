import numpy as np
import pytest

from analysis.identification.pole_search import triangular_factor

RNG = np.random.default_rng(3)


def solved(rows: np.ndarray, columns: int) -> tuple[np.ndarray, float]:
    """Solution and misfit of the one row of data behind the columns, from the factor."""
    triangle, lengths = triangular_factor(rows, columns)
    left = triangle[columns:, columns:]
    found = np.linalg.solve(triangle[:columns, :columns], triangle[:columns, columns]) / lengths
    return found, float(left[0, 0] ** 2)


@pytest.mark.parametrize("size", [1.0, 1e-150, 1e90])
def test_factor_solves_the_least_squares_problem(size: float) -> None:
    rows, scale = RNG.normal(size=(6, 40)), np.array([1.0, 1e-6, 1e4, 3.0, 0.2, size])
    wanted, misfit, *_ = np.linalg.lstsq(rows[:5].T, rows[5])
    found, left = solved(rows * scale[:, None], 5)
    np.testing.assert_allclose(found * scale[:5] / size, wanted, rtol=1e-9)
    assert left / size / size == pytest.approx(misfit[0], rel=1e-9)


def test_columns_that_coincide_share_what_one_would_take() -> None:
    """Beyond normal equations a ridge parts them, and the misfit is that of one of them alone."""
    rows = RNG.normal(size=(3, 40))
    twins = np.array([rows[0], rows[0] * (1.0 + 1e-12), rows[1]])
    _, misfit, *_ = np.linalg.lstsq(rows[:1].T, rows[1])
    found, left = solved(twins, 2)
    assert left == pytest.approx(misfit[0], rel=1e-6)
    assert found[0] == pytest.approx(found[1], rel=1e-3)


def test_data_that_the_columns_explain_to_the_last_digit_take_the_orthogonal_factor() -> None:
    rows = RNG.normal(size=(3, 40))
    exact = np.array([rows[0], rows[1], 2.0 * rows[0] - 3.0 * rows[1]])
    found, left = solved(exact, 2)
    np.testing.assert_allclose(found, [2.0, -3.0], rtol=1e-12)
    assert left < 1e-20 * float(exact[2] @ exact[2])
