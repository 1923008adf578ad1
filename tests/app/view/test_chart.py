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
