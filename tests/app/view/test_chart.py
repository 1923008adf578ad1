"""What a plot draws."""

import numpy as np
import pytest

pytest.importorskip("PySide6.QtWidgets", reason="Qt cannot be loaded here", exc_type=ImportError)

from PySide6.QtCore import QPointF

from app.view.application import application
from app.view.chart import Chart
from app.view.theme import LIGHT


def test_a_band_is_filled_between_its_edges_and_nowhere_else() -> None:
    application()
    chart = Chart("band", "", "x", "y", LIGHT)
    x = np.linspace(0.0, 1.0, 9)
    *edges, filling = chart.band(x, x - 1.0, x + 1.0, "#ff0000", "law")
    assert filling.path().contains(QPointF(0.5, 0.6))
    assert not filling.path().contains(QPointF(0.5, 1.7))
    assert [edge.opts["pen"].style().name for edge in edges] == ["NoPen", "NoPen"]
    assert [label for label, _, _ in chart.curves] == ["law, low", "law, high"]


@pytest.mark.parametrize(
    ("missing", "filled"),
    [([2], [0, 3, 4]), ([0, 3], [1, 4]), ([1, 4], [2]), ([2, 3, 5], [0]), ([0, 1, 3, 4, 5], []), (range(6), [])],
)
def test_a_band_is_not_filled_across_a_gap(missing: list[int], filled: list[int]) -> None:
    application()
    chart = Chart("band", "", "x", "y", LIGHT)
    low = np.zeros(6)
    low[missing] = np.nan
    *_, filling = chart.band(np.arange(6.0), low, np.ones(6), "#ff0000", "law")
    assert [n for n in range(5) if filling.path().contains(QPointF(n + 0.5, 0.5))] == filled
    chart.fit()
    chart.grab()
