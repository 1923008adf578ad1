"""Shapes with motion along several axes at one point: every direction is drawn, none over another."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("PySide6.QtSvg", reason="Qt cannot be loaded here", exc_type=ImportError)

from app.view.application import application
from app.view.test_run.modes_page import ARROW_LENGTH, ShapeChart
from app.view.theme import LIGHT

WIDE = 0.3


def held(points: dict[int, tuple[float, float, float]], motion: dict[str, float]) -> Any:
    """Make a test with one mode."""
    return SimpleNamespace(
        shapes=SimpleNamespace(places=list(motion), shape=np.array([list(motion.values())], complex), pole=[0]),
        frfs=SimpleNamespace(points=points),
        places=np.array([123.0]),
    )


def test_in_a_plane_motion_within_it_is_a_line_and_out_of_it_a_dot(shown: Any) -> None:
    points = {1: (0.0, 0.0, 0.0), 2: (WIDE, 0.0, 0.0), 3: (0.0, 0.2, 0.0), 4: (WIDE, 0.2, 0.0)}
    motion = {"1:+3": 1.0, "1:+1": 0.5, "2:+3": -1.0, "2:-2": 0.5, "3:+3": 0.2, "4:+1": 1.0}
    application()
    chart = shown(ShapeChart(held(points, motion), LIGHT))
    chart.show_shape(0)
    x, y = chart._points.getData()
    assert sorted(zip(x, y, strict=True)) == [(0.0, 0.0), (0.0, 0.2), (WIDE, 0.0), (WIDE, 0.2)]
    x, y = chart._within.getData()
    along, reach = np.stack([x, y], axis=1).reshape(-1, 2, 2), ARROW_LENGTH * WIDE
    np.testing.assert_allclose(along[:, 0], [points[1][:2], points[2][:2], points[4][:2]])
    np.testing.assert_allclose(along[:, 1] - along[:, 0], [[0.5 * reach, 0], [0, -0.5 * reach], [reach, 0]])


def test_on_a_line_every_direction_has_a_curve_of_its_own(shown: Any) -> None:
    points = {n: (0.1 * n, 0.0, 0.0) for n in (1, 2, 3)}
    motion = {f"{n}:+{axis}": 0.1 * n * (-1) ** axis for n in (3, 1, 2) for axis in (1, 3)}
    application()
    chart = shown(ShapeChart(held(points, motion | {"2:+2": 1.0}), LIGHT))
    chart.show_shape(0)
    drawn = {item.opts["label"]: item.getData() for item in chart.plotItem.listDataItems()}
    assert set(drawn) == {"along x", "along y", "along z"}
    np.testing.assert_allclose(drawn["along z"], [[0.1, 0.2, 0.3], [-0.1, -0.2, -0.3]])
    np.testing.assert_allclose(drawn["along y"], [[0.2], [1.0]])


def test_nodes_without_points_are_called_by_their_numbers(shown: Any) -> None:
    """They were numbered 1, 2, 3 in their order, with ticks at 1.5 and 2.5."""
    application()
    chart = shown(ShapeChart(held({}, {"7:+3": 1.0, "12:+3": -0.5, "3:+3": 0.2}), LIGHT))
    chart.show_shape(0)
    axis = chart.getAxis("bottom")
    assert axis._tickLevels[0] == [(1, "3"), (2, "7"), (3, "12")]
    assert axis.labelText == "node"
