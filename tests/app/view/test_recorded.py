"""The window on a recorded campaign, driven as a hand would."""

import csv
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("PySide6.QtSvg", reason="Qt cannot be loaded here", exc_type=ImportError)

import pyqtgraph
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QColor, QImage
from PySide6.QtWidgets import QLabel

from analysis.recordings.campaign import CampaignExtent
from app.files.provenance import provenance, sha256
from app.files.results.modes_file import load_frf, save_frf
from app.view.application import application
from app.view.chart import Chart
from app.view.folder import viewed
from app.view.frf_plots import decibels
from app.view.recorded.frf_page import FrfPage
from app.view.recorded.laws_page import LawsPage
from app.view.recorded.modes_page import ModesPage
from app.view.recorded.window import RecordedWindow
from app.view.theme import DARK, LIGHT, Theme

Open = Callable[[Path], RecordedWindow]


@pytest.fixture
def opened(shown: Callable[[Any], Any]) -> Open:
    def show(folder: Path) -> RecordedWindow:
        application()
        window: RecordedWindow = shown(RecordedWindow(viewed(folder), LIGHT))
        return window

    return show


def chart(window: RecordedWindow, name: str) -> Chart:
    found = window.centralWidget().findChild(Chart, name)
    assert isinstance(found, Chart)
    return found


def titles(window: RecordedWindow) -> list[str]:
    return [window.tabs.tabText(number) for number in range(window.tabs.count())]


def test_a_page_for_every_result_and_no_other(opened: Open, run: Path) -> None:
    assert titles(opened(run)) == ["FRFs", "Modes", "Laws"]
    (run / "modes.h5").unlink()
    assert titles(opened(run)) == ["FRFs", "Laws"]


def test_of_a_campaign_that_is_not_complete_the_title_says_how_many_sweeps(opened: Open, run: Path) -> None:
    assert opened(run).windowTitle() == "plate-run – Flexura"
    settings = {"extent": asdict(CampaignExtent("interrupted", 5, 31, 0, 0.0, 40.0))}
    save_frf(run / "frf.h5", *load_frf(run / "frf.h5"), provenance({"a.tdms": "00ff"}, settings))
    title = opened(run).windowTitle()
    assert title == "plate-run – interrupted, 5 of 31 sweeps, 0 to 40 °C – Flexura"


def test_results_of_fewer_sweeps_than_their_campaign_has_now_are_told_of(opened: Open, run: Path) -> None:
    campaign = run.with_name("plate")
    (campaign / "sweeps").mkdir(parents=True)
    for name in ("protocol.json", "sweeps/0000.h5", "sweeps/0001.h5"):
        (campaign / name).write_text(name, encoding="utf-8")
    inputs = {name: sha256(campaign / name) for name in ("protocol.json", "sweeps/0000.h5")}
    save_frf(run / "frf.h5", *load_frf(run / "frf.h5"), provenance(inputs))
    window = opened(run)
    said = window.centralWidget().findChild(QLabel, "trouble").text()
    assert said == (
        "frf.h5: made from 1 sweep of a campaign that has 2 finished ones now; "
        f"to take them in: flexura identify {campaign}"
    )
    assert window.page(0) is not None


def test_the_cursors_choose_both_cuts(opened: Open, run: Path, qtbot: Any) -> None:
    window = opened(run)
    page = window.page(0)
    assert isinstance(page, FrfPage)
    window.cursors.temperature, window.cursors.frequency = 30.0, 240.0
    h = page._frf.h
    along_f = {label: y for label, _, y in chart(window, "frf-at-temperature").curves}
    along_t = {label: (x, y) for label, x, y in chart(window, "frf-at-frequency").curves}
    np.testing.assert_allclose(along_f["measured"], decibels(h[3, 0]))
    np.testing.assert_allclose(along_t["measured"][0], decibels(h[:, 0, 70]))
    np.testing.assert_allclose(along_f["updated twin"] - along_f["measured"], 20 * np.log10(1.01), atol=1e-9)
    np.testing.assert_allclose(along_f["from poles and residues"], along_f["measured"], atol=1e-9)


def test_all_temperatures_are_laid_under_the_cut_and_taken_away(opened: Open, run: Path) -> None:
    window = opened(run)
    page, cut = window.page(0), chart(window, "frf-at-temperature")
    assert isinstance(page, FrfPage)
    before = len(cut.curves)
    page._every.setChecked(True)
    drawn = {label: y for label, _, y in cut.curves if label.endswith("°C")}
    assert len(drawn) == len(page._frf.h) == len(cut.curves) - before
    np.testing.assert_allclose(drawn[f"{page._frf.temperature[2]:.2f} °C"], decibels(page._frf.h[2, 0]))
    page._every.setChecked(False)
    assert len(cut.curves) == before


def test_logarithmic_frequencies_move_cuts_map_cursor_and_clicks_alike(
    opened: Open, run: Path, qtbot: Any
) -> None:
    window = opened(run)
    page, waterfall, cut = window.page(0), chart(window, "waterfall"), chart(window, "frf-at-temperature")
    assert isinstance(page, FrfPage)
    levels = cut.viewRange()[1]
    window.cursors.frequency = 300.0
    qtbot.keyClick(window, Qt.Key.Key_L)
    frequency = page._frf.frequency
    np.testing.assert_allclose(cut.curves[0][1], frequency)  # as exported, in Hz
    drawn = cut.plotItem.listDataItems()[0].getData()[0]
    np.testing.assert_allclose(drawn, np.log10(frequency))
    for one in (waterfall, cut):
        np.testing.assert_allclose(one.viewRange()[0], np.log10(frequency[[0, -1]]), atol=0.05)
    image = waterfall._image
    np.testing.assert_allclose(
        image.mapRectToParent(image.boundingRect()).left(), np.log10(frequency[0]), atol=0.02
    )
    np.testing.assert_allclose(cut.viewRange()[1], levels)
    lines = [line.value() for line in cut.plotItem.items if isinstance(line, pyqtgraph.InfiniteLine)]
    assert lines[0] == pytest.approx(np.log10(300.0))
    box = waterfall.plotItem.vb
    place = waterfall.mapFromScene(box.mapViewToScene(QPointF(np.log10(200.0), 20.0)))
    qtbot.mouseClick(waterfall.viewport(), Qt.MouseButton.LeftButton, pos=QPoint(place.x(), place.y()))
    assert abs(window.cursors.frequency - 200.0) < 6.0
    qtbot.keyClick(window, Qt.Key.Key_L)
    np.testing.assert_allclose(waterfall.viewRange()[0], frequency[[0, -1]], atol=2.0)


@pytest.mark.parametrize("theme", [DARK, LIGHT])
def test_the_line_beside_a_switch_can_be_seen(shown: Callable[[Any], Any], run: Path, theme: Theme) -> None:
    application()
    page = shown(RecordedWindow(viewed(run), theme)).page(0)
    assert isinstance(page, FrfPage)
    for switch in page.choices.overlays.values():
        drawn = switch.grab().toImage()
        beside = [drawn.pixelColor(1, y).lightness() for y in range(drawn.height())]
        assert max(abs(level - QColor(theme.window).lightness()) for level in beside) > 40


def test_differences_are_told_from_the_mark(opened: Open, run: Path, qtbot: Any) -> None:
    window = opened(run)
    page = window.page(0)
    assert isinstance(page, FrfPage)
    window.cursors.temperature, window.cursors.frequency = 20.0, 240.0
    qtbot.keyClick(window, Qt.Key.Key_M)
    assert "from mark" not in page._readout.text()
    for key in (Qt.Key.Key_Right, Qt.Key.Key_Up):
        qtbot.keyClick(window, key)
    frf, told = page._frf, page._readout.text()
    row = int(np.abs(frf.temperature - 20.0).argmin())
    line = int(np.abs(frf.frequency - 240.0).argmin())
    apart = decibels(frf.h[row + 1, 0, line + 1]) - decibels(frf.h[row, 0, line])
    assert f"{frf.frequency[line + 1] - frf.frequency[line]:+.2f} Hz" in told
    assert f"{float(apart):+.2f} dB" in told


def test_keys_move_the_cursors_by_lines_and_sweeps(opened: Open, run: Path, qtbot: Any) -> None:
    window = opened(run)
    window.cursors.temperature, window.cursors.frequency = 20.0, 300.0
    for key in (Qt.Key.Key_Right, Qt.Key.Key_Right, Qt.Key.Key_Up):
        qtbot.keyClick(window, key)
    qtbot.keyClick(window, Qt.Key.Key_Left, Qt.KeyboardModifier.ShiftModifier)
    assert (window.cursors.frequency, window.cursors.temperature) == (284.0, 30.0)
    for _ in range(9):
        qtbot.keyClick(window, Qt.Key.Key_Up)
    assert window.cursors.temperature == 40.0


def test_a_click_on_the_waterfall_takes_both_cursors_there(opened: Open, run: Path, qtbot: Any) -> None:
    window = opened(run)
    waterfall = chart(window, "waterfall")
    box = waterfall.plotItem.vb
    place = waterfall.mapFromScene(box.mapViewToScene(box.viewRect().center()))
    qtbot.mouseClick(waterfall.viewport(), Qt.MouseButton.LeftButton, pos=QPoint(place.x(), place.y()))
    assert window.cursors.temperature == 20.0
    assert abs(window.cursors.frequency - 499.0) < 8.0


def test_another_sensor_and_switched_off_overlays_change_what_is_drawn(opened: Open, run: Path) -> None:
    window = opened(run)
    page = window.page(0)
    assert isinstance(page, FrfPage)
    page.choices.channel.setCurrentIndex(1)
    for switch in page.choices.overlays.values():
        switch.setChecked(False)
    shown = chart(window, "waterfall").map
    assert shown is not None
    np.testing.assert_allclose(shown.value, decibels(page._frf.h[:, 1]))
    assert [label for label, _, _ in chart(window, "frf-at-temperature").curves] == ["measured"]


def test_a_mode_is_selected_with_keys_and_takes_the_frequency_cursor_along(
    opened: Open, run: Path, qtbot: Any
) -> None:
    window = opened(run)
    page = window.page(1)
    assert isinstance(page, ModesPage)
    window.cursors.temperature = 0.0
    qtbot.keyClick(window, Qt.Key.Key_BracketRight)
    assert page.selected == 1
    assert window.cursors.frequency == pytest.approx(320.0, rel=2e-3)
    window.cursors.temperature = 40.0
    page.select(2)
    assert page._readout.text().endswith("absent")


def test_the_shape_is_that_of_the_twins_mode_nearest_to_the_selected_one(
    opened: Open, run: Path, qtbot: Any
) -> None:
    window = opened(run)
    page = window.page(1)
    assert isinstance(page, ModesPage)
    shape = page.shape
    assert shape is not None
    qtbot.waitUntil(lambda: shape.chart is not None, timeout=60_000)
    assert shape.chart is not None
    qtbot.keyClick(window, Qt.Key.Key_Space)  # it stands still
    window.cursors.temperature = 20.0
    page.select(1)
    assert shape.chart.plotItem.titleLabel.text.startswith("the twin's mode 2: 293.0 Hz, η")
    seen = shape.chart.deflection / np.abs(shape.chart.deflection).max()
    assert seen.shape == (32, 25)
    waves = np.sin(2.0 * np.pi * np.linspace(0.0, 1.0, 32))
    np.testing.assert_allclose(np.abs(seen), np.abs(waves / np.abs(waves).max())[:, None] * np.ones(25), atol=1e-9)
    window.cursors.temperature = 40.0
    page.select(2)
    assert shape.chart.plotItem.titleLabel.text == "not identified at this temperature"


def test_a_run_without_laws_has_modes_without_shapes(opened: Open, run: Path) -> None:
    (run / "laws.h5").unlink()
    page = opened(run).page(1)
    assert isinstance(page, ModesPage)
    assert page.shape is None


def test_a_law_is_read_at_the_cursor_and_estimates_that_did_not_settle_are_marked(opened: Open, run: Path) -> None:
    window = opened(run)
    assert isinstance(window.page(2), LawsPage)
    window.cursors.temperature = 20.0
    law = chart(window, "law-youngs-modulus")
    value, sigma, unit = re.search(r"E = (\S+) ± (\S+) (\S+) at 20.0 °C", law.plotItem.titleLabel.text).groups()  # type: ignore[union-attr]
    assert float(value) == pytest.approx(2.4, abs=1e-3)
    assert len(value.split(".")[1]) == len(sigma.split(".")[1]) > 2
    assert unit == "GPa"
    curves = {label: (x, y) for label, x, y in law.curves}
    assert curves["not settled"][0].tolist() == [40.0]
    assert (curves["updated twin, high"][1] > curves["updated twin, low"][1]).all()


@pytest.mark.parametrize("name", ["frf.h5", "modes.h5", "laws.h5"])
def test_a_damaged_file_is_named_and_the_others_are_shown(opened: Open, run: Path, name: str) -> None:
    content = (run / name).read_bytes()
    (run / name).write_bytes(content[: len(content) // 2])
    window = opened(run)
    pages = [window.page(number) for number in range(3)]
    assert sum(page is None for page in pages) == 1
    assert pages[["frf.h5", "modes.h5", "laws.h5"].index(name)] is None
    assert window._trouble.isVisible()
    assert name in window._trouble.text()


def test_every_plot_in_sight_is_exported_and_the_numbers_are_those_drawn(
    opened: Open, run: Path, tmp_path: Path
) -> None:
    window = opened(run)
    window.cursors.temperature = 10.0
    written = window.export(tmp_path / "plots")
    assert {path.suffix for path in written} == {".png", ".svg", ".csv"}
    assert len(written) == 3 * len(window.charts) >= 12
    for path in written:
        if path.suffix == ".png":
            assert QImage(str(path)).width() > 300
        elif path.suffix == ".svg":
            assert ElementTree.parse(path).getroot().tag.endswith("svg")  # noqa: S314 (our own)
    with (tmp_path / "plots" / "frf-at-temperature.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    page = window.page(0)
    assert isinstance(page, FrfPage)
    seen = [float(row["measured: |H| [dB re 1 V/V]"]) for row in rows]
    np.testing.assert_allclose(seen, decibels(page._frf.h[1, 0]), rtol=1e-7)
    with (tmp_path / "plots" / "waterfall.csv").open(encoding="utf-8") as file:
        table = list(csv.reader(file))
    assert table[0][:2] == ["temperature [°C] \\ frequency [Hz]", "100"]
    np.testing.assert_allclose(np.array(table[1:], float)[:, 1:], decibels(page._frf.h[:, 0]), rtol=1e-7)


def test_the_theme_changes_and_page_and_cursors_stay(opened: Open, run: Path, qtbot: Any) -> None:
    window = opened(run)
    window.page(1)
    window.cursors.temperature = 30.0
    qtbot.keyClick(window, Qt.Key.Key_D)
    assert window.theme is DARK
    assert window.tabs.currentIndex() == 1
    assert window.cursors.temperature == 30.0
    corner = chart(window, "tracks-frequency").grab().toImage().pixelColor(2, 2)
    assert corner.name() == DARK.plot


def test_the_help_lists_every_key(opened: Open, run: Path, qtbot: Any) -> None:
    window = opened(run)
    qtbot.keyClick(window, Qt.Key.Key_F1)
    assert window._help.isVisible()
    for words in ("Ctrl+E", "Mode after", "Temperature cursor up", "Dark or light"):
        assert words in window._help.text()
    qtbot.keyClick(window, Qt.Key.Key_F1)
    assert not window._help.isVisible()


def test_a_zoomed_plot_is_whole_again_after_home(opened: Open, run: Path, qtbot: Any) -> None:
    window = opened(run)
    waterfall = chart(window, "waterfall")
    whole = waterfall.viewRange()
    waterfall.setXRange(300.0, 310.0)
    qtbot.keyClick(window, Qt.Key.Key_Home)
    np.testing.assert_allclose(waterfall.viewRange()[0], whole[0], rtol=1e-3)


def test_sweeps_of_several_actuators_are_shown_apart(opened: Open, run: Path) -> None:
    experiment, one = load_frf(run / "frf.h5")
    both = replace(
        one, temperature=np.tile(one.temperature, 2), direction=one.direction * 2, level=np.tile(one.level, 2),
        h=np.concatenate([3.0 * one.h, one.h]), variance=np.tile(one.variance, (2, 1, 1)),
        coherence=np.tile(one.coherence, (2, 1, 1)), source=np.repeat([0, 1], len(one.level)),
        labels=("S1/A1 [V/V]", "S2/A1 [V/V]", "S1/hammer [V/N]", "S2/hammer [V/N]"),
        units=("V/V", "V/V", "V/N", "V/N"), sources=("A1", "hammer"),
    )  # fmt: skip
    save_frf(run / "frf.h5", experiment, both, {})
    (run / "laws.h5").unlink()
    window = opened(run)
    page = window.page(0)
    assert isinstance(page, FrfPage)
    for place, (choice, label, unit) in enumerate(
        (("up, 1 V at A1", "S1/A1 [V/V]", "V/V"), ("up, 1 N at hammer", "S1/hammer [V/N]", "V/N"))
    ):
        page.choices.sweeps.setCurrentIndex(place)
        assert page.choices.sweeps.currentText() == choice
        assert page._waterfall.plotItem.titleLabel.text.endswith(label)
        assert f"{unit} =" in page._readout.text()
        np.testing.assert_array_equal(np.sort(page.rows), np.flatnonzero(both.source == place))
        drawn = {name: y for name, _, y in chart(window, "frf-at-temperature").curves}
        np.testing.assert_allclose(drawn["measured"], decibels(both.h[page.row, 0]))
        rebuilt = drawn["from poles and residues"]
        assert len(page._lines) == 3 * place  # the modes are the hammer's: its FRFs they explain
        if place:
            np.testing.assert_allclose(rebuilt, drawn["measured"], atol=1e-9)
        else:
            assert not np.isfinite(rebuilt).any()
