"""Nested dissection, on a square grid of cells, whose best separators are known."""

import numpy as np

from simulation.shell.unknowns import dissected

SIDE = 16


def grid() -> tuple[np.ndarray, np.ndarray]:
    """Corners of every cell of a square grid, (C, 4), and middles of the cells."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(SIDE), np.arange(SIDE), indexing="ij"))
    corner = x * (SIDE + 1) + y
    members = np.stack([corner, corner + 1, corner + SIDE + 1, corner + SIDE + 2], axis=1)
    return members, np.stack([x + 0.5, y + 0.5], axis=1)


def filled(members: np.ndarray, order: np.ndarray) -> int:
    """Entries of a factor below its diagonal, by elimination on sets."""
    neighbours = [set() for _ in order]
    for cell in members:
        for part in cell:
            neighbours[part] |= set(cell[cell >= 0].tolist()) - {int(part)}
    total = 0
    for part in order.tolist():
        around = neighbours[part]
        total += len(around)
        for other in around:
            neighbours[other] |= around - {other}
            neighbours[other].discard(part)
    return total


def test_the_last_to_go_is_a_line_through_the_middle() -> None:
    members, places = grid()
    order = dissected(members, np.ones((SIDE + 1) ** 2), places)
    assert np.array_equal(np.sort(order), np.arange((SIDE + 1) ** 2))
    last = np.stack(np.divmod(order[-SIDE - 1 :], SIDE + 1))
    assert (np.ptp(last, axis=1) == 0).any()
    assert abs(last[np.ptp(last, axis=1) == 0][0, 0] - SIDE / 2) <= 2


def test_factors_fill_less_than_row_by_row() -> None:
    members, places = grid()
    order = dissected(members, np.ones((SIDE + 1) ** 2), places)
    # row by row fills a band as wide as the grid
    assert filled(members, order) < 0.8 * filled(members, np.arange((SIDE + 1) ** 2))


def test_large_parts_are_cut_around() -> None:
    members, places = grid()
    size = np.ones((SIDE + 1, SIDE + 1))
    size[SIDE // 2, :] = size[:, SIDE // 2] = 5.0
    last = dissected(members, size.ravel(), places)[-SIDE - 1 :]
    assert size.ravel()[last].sum() < 2 * (SIDE + 1)


def test_cells_may_have_fewer_parts() -> None:
    members = np.array([[0, 1, 2, -1], [1, 2, 3, 4], [3, 4, 5, -1]])
    order = dissected(members, np.ones(6), np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]))
    assert sorted(order.tolist()) == list(range(6))
