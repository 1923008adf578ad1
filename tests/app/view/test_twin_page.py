"""Modes of test and twin in the window: pairs, MAC with its values, what is copied."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("PySide6.QtSvg", reason="Qt cannot be loaded here", exc_type=ImportError)

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication

from analysis.pairing.assignment import ModeList, PairedSweeps, Pairing, pair_modes
from app.files.results.laws_file import load_laws, load_updated, save_laws
from app.files.results.pairing_json import pairing_record
from app.view.application import application
from app.view.folder import viewed
from app.view.recorded.window import RecordedWindow
from app.view.theme import LIGHT
from app.view.twin_page import TwinPage
from tests.app.view.conftest import MADE

MEASURED, COMPUTED = np.array([180.0, 320.0, 610.0]), np.array([181.0, 318.0, 470.0, 612.0, 2000.0])
SHAPES = np.array([[1.0, 2.0, -1.0], [2.0, -1.0, 1.0], [0.0, 1.0, 2.0]])
"""Columns: three shapes at three channels."""


def of(frequency: np.ndarray[Any, Any], shapes: np.ndarray[Any, Any]) -> ModeList:
    ones = np.ones(len(frequency))
    return ModeList(frequency, 0.01 * ones, 0.03 * ones, 1e-4 * ones, 100.0 * shapes.astype(complex), ones > 0.0)


def record(channels: int = 3, *, after: bool = False) -> dict[str, Any]:
    """Return a pairing whose fourth mode of the twin was not measured, and whose fifth lies far above."""
    more = np.array([[1.0, 1.0], [1.0, 0.0], [1.0, 1.0]])
    twin = np.column_stack([SHAPES[:, :2], more[:, :1], SHAPES[:, 2:], more[:, 1:]])[:channels]
    pairs = tuple(
        pair_modes(t, (100.0, 900.0), of(MEASURED, SHAPES[:channels]), of(COMPUTED, twin)) for t in (0.0, 40.0)
    )
    swept = PairedSweeps(pairs, np.array([0.02, 0.03]), np.array([0.01, 0.01]), "modes.h5")
    found = pairing_record(Pairing(swept, swept if after else None))
    assert found is not None
    return json.loads(json.dumps(found, allow_nan=False))


def expected(rows: np.ndarray[Any, Any], columns: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """MAC by its definition, one pair at a time."""
    return np.array([[(a @ b) ** 2 / ((a @ a) * (b @ b)) for b in columns.T] for a in rows.T])


@pytest.fixture
def page(qtbot: Any) -> TwinPage:
    application()
    made = TwinPage(record(), LIGHT)
    made.resize(1200, 700)
    qtbot.addWidget(made)
    made.show()
    return made


def test_the_mac_of_test_and_twin_is_that_of_its_definition(page: TwinPage) -> None:
    assert page.alike.map is not None
    twin = np.column_stack([SHAPES[:, :2], np.ones(3), SHAPES[:, 2:]])
    np.testing.assert_allclose(page.alike.map.value, expected(SHAPES, twin), atol=1e-4)  # the far mode is left out
    written = [item.toPlainText() for item, _ in page.alike._written]
    assert written == [f"{value:.2f}" for value in page.alike.map.value.ravel()]
    assert all(item.isVisible() for item, _ in page.alike._written)


def test_values_get_smaller_with_their_cells_and_go_where_nobody_could_read_them(page: TwinPage) -> None:
    def written(columns: int) -> tuple[set[str], set[bool]]:
        """First characters of all values, and whether they are seen."""
        many = np.tile(page.alike.map.value[:, :1], (1, columns))  # type: ignore[union-attr]
        page.alike.show_mac(many, ["1", "2", "3"], [str(n) for n in range(columns)])
        return (
            {item.toPlainText()[:1] for item, _ in page.alike._written},
            {item.isVisible() for item, _ in page.alike._written},
        )

    QApplication.processEvents()
    assert written(4) == ({"0", "1"}, {True})
    assert written(28) == ({".", "1"}, {True})
    assert written(60)[1] == {False}
    assert written(61) == (set(), set())


def test_ctrl_c_copies_all_values_of_the_mac_and_all_of_the_table(page: TwinPage, qtbot: Any) -> None:
    qtbot.keyClick(page.alike, Qt.Key.Key_C, Qt.KeyboardModifier.ControlModifier)
    lines = [line.split("\t") for line in QApplication.clipboard().text().splitlines()]
    assert lines[0] == ["MAC", "181.0", "318.0", "470.0", "612.0"]
    assert [line[0] for line in lines[1:]] == ["180.0", "320.0", "610.0"]
    np.testing.assert_allclose([[float(v) for v in line[1:]] for line in lines[1:]], page.alike.map.value)  # type: ignore[union-attr]
    qtbot.keyClick(page.table, Qt.Key.Key_C, Qt.KeyboardModifier.ControlModifier)
    copied = [line.split("\t") for line in QApplication.clipboard().text().splitlines()]
    assert [row[:2] for row in copied[1:]] == [
        ["180.0", "181.0"],
        ["320.0", "318.0"],
        ["none", "470.0"],
        ["610.0", "612.0"],
    ]


def test_another_temperature_and_the_twin_without_its_effects_can_be_chosen(qtbot: Any) -> None:
    application()
    page = TwinPage(record(after=True), LIGHT)
    qtbot.addWidget(page)
    texts = [page.choice.itemText(n) for n in range(page.choice.count())]
    assert texts == [f"{t} °C{w}" for w in (", with the effects found", "") for t in ("0.0", "40.0")]
    assert page.said.text().startswith("Modes at 40.0 °C")  # the sweep of the larger misfit
    page.choice.setCurrentIndex(2)
    assert page.said.text().startswith("Modes at 0.0 °C")


def test_one_channel_has_pairs_but_no_mac(qtbot: Any) -> None:
    application()
    page = TwinPage(record(1), LIGHT)
    qtbot.addWidget(page)
    assert page.alike.map is None
    assert "one channel alone has no shape" in page.alike.plotItem.titleLabel.text
    assert page.table.rowCount() > 0


def test_the_window_on_a_campaign_has_the_page_where_modes_were_paired(
    run: Path, shown: Callable[[Any], Any]
) -> None:
    application()
    window = RecordedWindow(viewed(run), LIGHT)
    assert "Twin" not in [window.tabs.tabText(n) for n in range(window.tabs.count())]
    laws, (found, twin) = load_laws(run / "laws.h5"), load_updated(run / "laws.h5")
    save_laws(run / "laws.h5", found, laws, twin, MADE, record())
    window = shown(RecordedWindow(viewed(run), LIGHT))
    titles = [window.tabs.tabText(n) for n in range(window.tabs.count())]
    assert titles == ["FRFs", "Modes", "Laws", "Twin"]
    assert isinstance(window.page(3), TwinPage)
