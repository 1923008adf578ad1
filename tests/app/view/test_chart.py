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


@pytest.mark.parametrize(
    ("y", "corner"),
    [(np.linspace(0.0, 1.0, 50), "upper left"), (np.linspace(1.0, 0.0, 50), "upper right")],
)
def test_a_legend_stands_where_it_hides_nothing(y: np.ndarray, corner: str) -> None:
    application()
    chart = Chart("laws", "", "x", "y", LIGHT)
    chart.resize(420, 260)
    chart.legend(offset=(-8, 8))
    chart.curve(np.linspace(0.0, 1.0, 50), y, "a law of some length", "#ff0000")
    chart.show()
    chart.fit()
    assert hidden(chart) == 0
    view, legend = chart.plotItem.vb, chart.plotItem.legend
    left = legend.pos().x() < 0.5 * (view.width() - legend.width())
    upper = legend.pos().y() < 0.5 * (view.height() - legend.height())
    assert f"{'upper' if upper else 'lower'} {'left' if left else 'right'}" == corner


def test_where_curves_are_in_every_corner_there_is_room_above_them() -> None:
    application()
    chart = Chart("laws", "", "x", "y", LIGHT)
    chart.resize(420, 260)
    chart.legend()
    for n in range(3):
        x = np.linspace(0.0, 1.0, 300)
        chart.curve(x, np.sin(40.0 * x + n), f"curve {n}", "#ff0000")
    chart.show()
    chart.fit()
    assert hidden(chart) == 0
    assert chart.viewRange()[1][0] <= -1.0
    chart.resize(340, 240)
    chart.fit()
    assert hidden(chart) == 0


def test_a_legend_lies_over_no_points_of_a_plot_that_got_its_size_later() -> None:
    """Three points hidden weighed less than a curve, and a plot that was resized made no room."""
    application()
    chart = Chart("misfit", "", "x", "y", LIGHT)
    chart.legend(offset=(8, 8))
    x = np.linspace(15.0, 45.0, 7)
    chart.curve(
        x, np.full(7, 3.5), "by update, before the gap was looked for", "#ff0000", style="none", points=True
    )
    chart.curve(x, np.full(7, 0.5), "noise of the measurement", "#ff0000")
    chart.fit()
    chart.resize(420, 260)
    chart.show()
    assert covered(chart) == 0
    before = chart.viewRange()[1]
    chart.resize(340, 240)
    assert covered(chart) == 0
    chart.resize(700, 900)
    assert chart.viewRange()[1][1] < before[1]  # the room above the curves is what the legend needs
    chart.setYRange(0.0, 4.0, padding=0.0)
    chart.resize(420, 260)
    assert chart.viewRange()[1] == pytest.approx([0.0, 4.0])  # what somebody chose to look at stays


def test_there_is_no_curve_between_points_that_no_line_connects() -> None:
    application()
    chart = Chart("misfit", "", "x", "y", LIGHT)
    chart.resize(420, 260)
    chart.legend(offset=(8, 8))
    chart.curve([0.0, 0.6, 1.0], [0.5, 1.0, 0.0], "three points", "#ff0000", style="none", points=True)
    chart.show()
    chart.fit()
    assert covered(chart) == 0
    assert chart.plotItem.legend.pos().x() == 8.0  # where it is wanted, across no curve
    assert chart.plotItem.legend.pos().y() == 8.0
    assert chart.viewRange()[1][1] < 1.1


def covered(chart: Chart) -> int:
    """Count points given, with the marks drawn around them, that the legend lies over."""
    view, legend = chart.plotItem.vb, chart.plotItem.legend
    box, found = legend.mapRectToItem(view, legend.boundingRect()), 0
    for item in chart.plotItem.listDataItems():
        reach = 0.0 if item.opts["symbol"] is None else 2.0
        places = [view.mapFromView(QPointF(a, b)) for a, b in zip(*item.getOriginalDataset(), strict=True)]
        found += sum(box.adjusted(-reach, -reach, reach, reach).contains(place) for place in places)
    return found


def hidden(chart: Chart) -> int:
    """Count points of curves, 1000 along each, below the legend."""
    view, legend = chart.plotItem.vb, chart.plotItem.legend
    box = legend.mapRectToItem(view, legend.boundingRect())
    found = 0
    for _, x, y in chart.curves:
        for a in np.linspace(x[0], x[-1], 1000):
            found += box.contains(view.mapFromView(QPointF(a, float(np.interp(a, x, y)))))
    return found
