"""Numbers of a logarithmic axis: true, apart, and there at every zoom."""

import numpy as np
import pytest

pytest.importorskip("PySide6.QtWidgets", reason="Qt cannot be loaded here", exc_type=ImportError)

import pyqtgraph

from app.view.application import application
from app.view.chart import LEAST_NUMBER_DISTANCE, LogAxis, Map, log_places
from app.view.cursors import Cursors, FrequencyAxis
from app.view.map_chart import MapChart
from app.view.theme import LIGHT


@pytest.mark.parametrize(
    ("low", "high"), [(100.0, 1500.0), (1.0, 1e5), (100.0, 190.0), (700.0, 720.0), (0.02, 3.0)]
)
@pytest.mark.parametrize("size", [260.0, 900.0])
def test_numbers_are_those_of_the_ticks_and_have_room(low: float, high: float, size: float) -> None:
    application()
    axis = LogAxis("bottom")
    axis.setLogMode(True)
    span = np.log10(low), np.log10(high)
    told = [row for spacing, row in axis.logTickValues(*span, size, None) if spacing is not None]
    ticks = np.sort(np.concatenate(told))
    assert len(ticks) >= 2
    assert (ticks >= span[0]).all()
    assert (ticks <= span[1]).all()
    assert (np.diff(ticks) * size / (span[1] - span[0])).min() > 0.75 * LEAST_NUMBER_DISTANCE
    words = axis.logTickStrings(ticks.tolist(), 1.0, 1.0)
    np.testing.assert_allclose([float(word) for word in words], 10.0**ticks, rtol=1e-5)
    assert len(set(words)) == len(words)


def test_a_line_at_0_hz_has_a_place() -> None:
    lines = np.array([0.0, 2.0, 20.0])
    np.testing.assert_allclose(10.0 ** log_places(lines, lines), [1.0, 2.0, 20.0])


def test_cursor_and_map_stand_at_0_hz() -> None:
    app = application()
    lines = np.arange(0.0, 40.0, 2.0)
    cursors = Cursors(10.0, 20.0)
    placed: list[float] = []
    axis = FrequencyAxis(lines, cursors)
    axis.placed.connect(placed.append)
    chart = MapChart("map", "map", "Hz", "degC", LIGHT)
    axis.add(chart)
    chart.image(
        Map(lines, np.arange(3.0), np.zeros((3, lines.size))), pyqtgraph.colormap.get("viridis"), (0.0, 1.0), ""
    )
    axis.setChecked(True)
    cursors.frequency = 0.0
    app.processEvents()
    assert placed[-1] == 0.0  # 1 Hz, half of the next line
    assert np.isfinite(chart.viewRange()).all()
