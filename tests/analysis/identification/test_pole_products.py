import numpy as np
import pytest

from analysis.identification.lines import WeightedLines
from analysis.identification.pole_residue import fill_columns

RNG = np.random.default_rng(11)
W = 2 * np.pi * np.arange(100.0, 400.0, 0.5)
WEIGHT = RNG.uniform(0.5, 2.0, len(W))
ROWS = (RNG.normal(size=(4, len(W))) + 1j * RNG.normal(size=(4, len(W)))) * WEIGHT
ROWS[0] = WEIGHT  # residual terms are real or imaginary
ROWS[1] = 1j * WEIGHT

NARROWEST = 0.1 * 2 * np.pi * 0.5
"""Half width at the bound of a search."""

CASES = {
    "apart": np.array([150.0, 210.0, 228.0]) * (1j - 0.02),
    "close": np.array([150.0, 150.0 * (1 + 1e-6), 150.3]) * (1j - 0.02),
    "background": np.array([60.0, 300.0, 900.0]) * (0.8j - 0.6),
    "needles": np.array([150.0, 150.25, 150.5, 310.1]) * 1j - NARROWEST / (2 * np.pi),
}


def line_by_line(poles: np.ndarray, rows: np.ndarray, before: int) -> np.ndarray:
    """Columns, rows and derivative columns written out, in the order of `gram`."""
    columns, moved = np.empty((2, 2 * len(poles), len(W)), dtype=complex)
    fill_columns(1j * W, poles, columns, moved)
    return np.concatenate([columns * WEIGHT, rows[:before], moved * WEIGHT, rows[before:]]).view(float)


@pytest.mark.parametrize("case", CASES)
def test_products_are_those_of_the_lines(case: str) -> None:
    poles = 2 * np.pi * CASES[case]
    written = line_by_line(poles, ROWS, 3)
    wanted = written @ written.T
    length = np.sqrt(np.diagonal(wanted))
    lines = WeightedLines.of(W, WEIGHT, ROWS)
    found = lines.at(poles, derivatives=True).gram(3)
    np.testing.assert_allclose(
        np.tril(found / length / length[:, None]), np.tril(wanted / length / length[:, None]), atol=1e-11
    )
    np.testing.assert_allclose(lines.line_by_line(poles, 3, derivatives=True), written, rtol=1e-12)
    few = [*range(2 * len(poles) + 3), len(wanted) - 1]  # without the derivative columns
    np.testing.assert_allclose(np.tril(lines.at(poles).gram(3)), np.tril(found)[np.ix_(few, few)], rtol=1e-12)


def test_products_with_other_poles_are_those_of_the_lines() -> None:
    poles, others = 2 * np.pi * CASES["apart"], 2 * np.pi * np.append(CASES["close"], CASES["apart"][0])
    written = line_by_line(poles, ROWS, 2)
    columns = line_by_line(others, ROWS[:0], 0)[: 2 * len(others)]
    lines = WeightedLines.of(W, WEIGHT, ROWS)
    there = lines.at(others)
    found = lines.at(poles, derivatives=True).with_columns_of(there, 2)
    length = np.sqrt((columns**2).sum(axis=1))
    np.testing.assert_allclose(there.squares, length**2, rtol=1e-11)
    scale = np.sqrt((written**2).sum(axis=1))[:, None] * length
    np.testing.assert_allclose(found / scale, written @ columns.T / scale, atol=1e-12)


def test_products_with_columns_times_a_row_are_those_of_the_lines() -> None:
    poles = 2 * np.pi * CASES["close"]
    columns = np.empty((2 * len(poles), len(W)), dtype=complex)
    fill_columns(1j * W, poles, columns)
    wanted = (columns.conj() * WEIGHT) @ (columns * ROWS[3]).T
    found = WeightedLines.of(W, WEIGHT, ROWS).at(poles).times_row(3)
    np.testing.assert_allclose(found, wanted.real, atol=1e-12 * np.abs(columns).max() ** 2 * len(W))


def test_without_poles_the_rows_remain() -> None:
    found = WeightedLines.of(W, WEIGHT, ROWS).at(np.zeros(0, complex), derivatives=True).gram(2)
    np.testing.assert_allclose(np.tril(found), np.tril(ROWS.view(float) @ ROWS.view(float).T))
