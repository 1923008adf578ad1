"""What stands first in a universal file, read back by pyuff."""

from pathlib import Path

import numpy as np
import pytest
import pyuff

from analysis.shapes.participation import faces_between, lines_between
from app.files.uff.geometry import geometry_text, read_nodes

GRID = {1 + i + 4 * j: (0.1 * i, 0.07 * j, 0.012345678901) for i in range(4) for j in range(3)}


def sets(path: Path, text: str) -> list[dict]:
    path.write_text(text, encoding="ascii")
    read = pyuff.UFF(str(path)).read_sets()
    return read if isinstance(read, list) else [read]


def test_header_and_units_stand_first_without_nodes(tmp_path: Path) -> None:
    header, units = sets(tmp_path / "a.uff", geometry_text("a plate"))
    assert (header["type"], header["model_name"].strip()) == (151, "a plate")
    assert (units["type"], units["units_code"], units["length"], units["force"]) == (164, 1, 1.0, 1.0)


def test_every_set_is_read_and_nodes_keep_their_digits(tmp_path: Path) -> None:
    path = tmp_path / "a.uff"
    read = sets(path, geometry_text("a plate", GRID))
    assert [one["type"] for one in read][:4] == [15, 151, 164, 2411]
    assert {one["type"] for one in read[4:]} == {82}
    found = read_nodes(path)
    assert list(found) == list(GRID)
    np.testing.assert_array_equal(np.array(list(found.values())), np.array(list(GRID.values())))


def test_numbers_are_such_as_every_language_reads() -> None:
    """SDynPy 0.23 ended in an error at ``7.14D-02``, the first coordinate, and read no FRF."""
    lines = geometry_text("a plate", GRID).splitlines()
    first = lines.index(f"  2411{'':74}") + 2
    places = [[float(number) for number in line.split()] for line in lines[first : first + 24 : 2]]
    np.testing.assert_array_equal(places, np.array(list(GRID.values())))
    first = lines.index(f"   164{'':74}") + 2
    assert [float(number) for line in lines[first : first + 2] for number in line.split()] == [1, 1, 1, 273.15]


@pytest.mark.parametrize("seed", range(5))
def test_lines_cross_nowhere_in_whatever_order_points_were_hit(seed: int) -> None:
    """Ten points of a rim and eight inside, numbered at random."""
    rng = np.random.default_rng(seed)
    turn = 0.2 * np.pi * np.arange(10)
    rim, inside = np.stack([0.3 * np.cos(turn), 0.2 * np.sin(turn)], axis=1), rng.uniform(-0.12, 0.12, (8, 2))
    places = rng.permutation(np.vstack([rim, inside]))
    points = {n + 1: (float(x), float(y), 0.0) for n, (x, y) in enumerate(places)}
    lines = lines_between(points)
    assert {node for line in lines for node in line} == set(points)

    def turned(a: int, b: int, c: int) -> float:
        (ax, ay, _), (bx, by, _), (cx, cy, _) = points[a], points[b], points[c]
        return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)

    for number, (a, b) in enumerate(lines):
        for c, d in lines[:number]:
            if len({a, b, c, d}) == 4:
                apart = turned(a, b, c) * turned(a, b, d) > 0.0 or turned(c, d, a) * turned(c, d, b) > 0.0
                assert apart, (a, b, c, d)


def test_lines_join_neighbours_of_a_grid() -> None:
    """17 sides of its cells and a diagonal of each; none over a cell."""
    lines = lines_between(GRID)
    assert len(lines) == 17 + 6
    longest = max(np.linalg.norm(np.subtract(GRID[a], GRID[b])) for a, b in lines)
    assert longest == pytest.approx(np.hypot(0.1, 0.07))


def test_faces_fill_the_cells_of_a_grid_and_leave_holes_open() -> None:
    assert len(faces_between(GRID)) == 2 * 6
    ring = {10 * i + j: (0.1 * i, 0.1 * j, 0.0) for i in range(5) for j in range(5) if (i, j) != (2, 2)}
    corners = np.array([[ring[node][:2] for node in face] for face in faces_between(ring)])
    one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = 0.5 * np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0])
    assert area.sum() <= 0.16 - 0.5 * 0.01  # of the four cells around the missing node half is left open
    assert faces_between({n: (0.1 * n, 0.0, 0.0) for n in range(5)}) == []


def test_nodes_of_one_line_are_joined_along_it(tmp_path: Path) -> None:
    beam = {node: (0.1 * x, 0.2 * x, 0.0) for node, x in ((1, 3), (2, 0), (7, 2), (9, 1))}
    (line,) = lines_between(beam)
    assert line in ([2, 9, 7, 1], [1, 7, 9, 2])
    read = sets(tmp_path / "a.uff", geometry_text("beam", {n: (0.01 * n, 0.0, 0.0) for n in range(1, 20)}))
    assert [int(n) for n in read[-1]["nodes"]] in ([*range(1, 20)], [*range(19, 0, -1)])


@pytest.mark.parametrize("points", [{}, {3: (0.0, 0.0, 0.0)}, {1: (0.1, 0.0, 0.0), 2: (0.1, 0.0, 0.0)}])
def test_fewer_than_two_places_have_no_line(points: dict, tmp_path: Path) -> None:
    assert lines_between(points) == []
    assert {one["type"] for one in sets(tmp_path / "a.uff", geometry_text("x", points))} >= {151, 164}
