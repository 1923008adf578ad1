"""The window on a campaign: table of modes, parts of an FRF, Nyquist plane."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("PySide6.QtSvg", reason="Qt cannot be loaded here", exc_type=ImportError)

from PySide6.QtCore import Qt

from analysis.recordings.frf import Frf
from app.files.results.modes_file import load_modes, save_frf, save_modes
from app.report.measured import over_temperature
from app.view.application import application
from app.view.chart import Chart
from app.view.folder import viewed
from app.view.frf_plots import decibels
from app.view.recorded.frf_page import FrfPage
from app.view.recorded.modes_page import ModesPage
from app.view.recorded.window import RecordedWindow
from app.view.theme import LIGHT
from tests.app.view.conftest import MADE, NATURAL, experiment, frf


@pytest.fixture
def window(shown: Callable[[Any], Any], run: Path) -> RecordedWindow:
    application()
    opened: RecordedWindow = shown(RecordedWindow(viewed(run), LIGHT))
    return opened


def frf_page(window: RecordedWindow) -> FrfPage:
    page = window.page(0)
    assert isinstance(page, FrfPage)
    return page


def modes_page(window: RecordedWindow) -> ModesPage:
    page = window.page(1)
    assert isinstance(page, ModesPage)
    return page


def cells(page: ModesPage, column: int) -> list[str]:
    table = page.table
    return [item.text() for row in range(table.rowCount()) if (item := table.item(row, column)) is not None]


def click(page: ModesPage, row: int, qtbot: Any) -> None:
    item = page.table.item(row, 1)
    assert item is not None
    place = page.table.visualItemRect(item).center()
    qtbot.mouseClick(page.table.viewport(), Qt.MouseButton.LeftButton, pos=place)


def curves(chart: Chart) -> dict[str, tuple[Any, Any]]:
    return {label: (x, y) for label, x, y in chart.curves}


def test_it_fits_a_small_screen(window: RecordedWindow) -> None:
    for number in range(window.tabs.count()):
        window.page(number)
        assert window.minimumSizeHint().width() <= 1280
        assert window.minimumSizeHint().height() <= 800


def test_the_table_lists_the_modes_at_the_temperature_cursor(window: RecordedWindow) -> None:
    page = modes_page(window)
    window.cursors.temperature = 0.0
    at_zero = NATURAL * np.sqrt(1.0 - 2 * 0.03**2)
    assert cells(page, 0) == ["1", "2", "3"]
    assert [float(text) for text in cells(page, 1)] == pytest.approx(list(at_zero), abs=1e-3)
    assert [float(text) for text in cells(page, 3)] == pytest.approx([3.0] * 3)
    assert cells(page, 6) == ["kept", "kept", "weak"]
    assert cells(page, 7)[2] == "faint"
    window.cursors.temperature = 40.0  # the third mode is there, but belongs to no track
    assert cells(page, 0) == ["1", "2", "–"]
    assert [float(text) for text in cells(page, 1)] == pytest.approx(list(0.8 * at_zero), abs=1e-3)


def test_a_row_that_is_chosen_takes_cursor_and_curve_along(window: RecordedWindow, qtbot: Any) -> None:
    page = modes_page(window)
    window.cursors.temperature = 10.0
    click(page, 2, qtbot)
    assert window.cursors.frequency == pytest.approx(float(cells(page, 1)[2]), abs=1e-3)
    assert page.selected == 2
    window.cursors.temperature = 40.0
    click(page, 2, qtbot)  # not tracked: the cursor goes there, no other curve stands out
    assert window.cursors.frequency == pytest.approx(float(cells(page, 1)[2]), abs=1e-3)
    assert page.selected == 2


def test_the_row_of_the_mode_nearest_to_the_cursor_is_marked(window: RecordedWindow) -> None:
    page = modes_page(window)
    window.cursors.temperature = 0.0
    for frequency, row in ((200.0, 0), (300.0, 1), (850.0, 2)):
        window.cursors.frequency = frequency
        assert [index.row() for index in page.table.selectionModel().selectedRows()] == [row]
        assert page.selected == row
        assert window.cursors.frequency == frequency  # marking moves nothing
        bold = [page.table.item(n, 0).font().bold() for n in range(3)]  # type: ignore[union-attr]
        assert bold == [n == row for n in range(3)]


def test_a_mode_that_is_absent_at_the_cursor_can_stand_out_all_the_same(window: RecordedWindow) -> None:
    page = modes_page(window)
    window.cursors.temperature = 40.0
    page.select(0)
    page.select(2)
    assert page.selected == 2
    assert window.cursors.frequency == pytest.approx(0.8 * NATURAL[0], rel=2e-3)
    assert [index.row() for index in page.table.selectionModel().selectedRows()] == [0]


def test_change_against_the_cursor_stays_in_sight(window: RecordedWindow) -> None:
    modes_page(window)
    window.cursors.temperature = 0.0
    chart = window.centralWidget().findChild(Chart, "tracks-change")
    assert isinstance(chart, Chart)
    low, high = chart.viewRange()[1]
    for _, _, change in chart.curves:
        assert low <= np.nanmin(change)
        assert np.nanmax(change) <= high


def test_change_reaches_as_far_as_the_lines_drawn(shown: Callable[[Any], Any], run: Path) -> None:
    found = load_modes(run / "modes.h5")
    track = found.track.copy()
    track[:, 0] = [2, -1, 0, 0, 0]  # another mode, taken for this one at the lowest temperature
    found = replace(found, track=track[:, :2])
    save_modes(run / "modes.h5", found, MADE)
    window = shown(RecordedWindow(viewed(run), LIGHT))
    modes_page(window)
    chart = window.centralWidget().findChild(Chart, "tracks-change")
    assert isinstance(chart, Chart)
    assert 5.0 < chart.viewRange()[1][1] < 20.0
    assert 5.0 < over_temperature(found).axes[1].get_ylim()[1] < 20.0


def test_the_page_reads_poles_as_was_chosen(shown: Callable[[Any], Any], run: Path) -> None:
    save_modes(run / "modes.h5", load_modes(run / "modes.h5").read_as("viscous"), MADE)
    application()
    window = shown(RecordedWindow(viewed(run), LIGHT))
    page = modes_page(window)
    window.cursors.temperature = 0.0
    assert cells(page, 1) == [f"{f:.3f}" for f in NATURAL]
    page.select(1)
    assert "320.00 ±" in page._readout.text()
    assert "viscous" in page.table.toolTip()


def test_a_run_without_modes_says_so(shown: Callable[[Any], Any], run: Path) -> None:
    found = load_modes(run / "modes.h5")
    save_modes(run / "modes.h5", replace(found, track=found.track[:, :0]), MADE)
    application()
    window = shown(RecordedWindow(viewed(run), LIGHT))
    assert window.page(1) is None
    assert window._trouble.text() == "modes.h5: no modes were found"


def test_real_and_imaginary_part_are_drawn_in_place_of_magnitude_and_phase(window: RecordedWindow) -> None:
    page = frf_page(window)
    page.choices.channel.setCurrentIndex(1)
    window.cursors.temperature = 20.0
    page.choices.display.setCurrentIndex(1)
    h = page._frf.h[2, 1]
    for chart, part, label in (
        (page.cut.above, h.real, "Re H [V/V]"),
        (page.cut.below, h.imag, "Im H [V/V]"),
    ):
        assert chart.labels[1] == label
        np.testing.assert_allclose(curves(chart)["measured"][1], part)
        np.testing.assert_allclose(curves(chart)["from poles and residues"][1], part, atol=1e-9)
        low, high = chart.viewRange()[1]
        assert low < part.min() < part.max() < high
    page._every.setChecked(True)
    np.testing.assert_allclose(curves(page.cut.above)["0.00 °C"][1], page._frf.h[0, 1].real)
    page.choices.display.setCurrentIndex(0)
    np.testing.assert_allclose(curves(page.cut.above)["measured"][1], decibels(h))
    assert page.cut.below.viewRange()[1] == pytest.approx([-180.0, 180.0], abs=40.0)
    assert page.cut.above.labels[1] == "|H| [dB re 1 V/V]"


def test_the_phase_is_not_drawn_where_it_is_noise(shown: Callable[[Any], Any], run: Path) -> None:
    quiet: Frf = frf()
    variance = quiet.variance.copy()
    variance[:, :, :50] = np.abs(quiet.h[:, :, :50]) ** 2
    save_frf(run / "frf.h5", experiment(), replace(quiet, variance=variance), MADE)
    application()
    page = frf_page(shown(RecordedWindow(viewed(run), LIGHT)))
    frequency, phase = curves(page.cut.below)["measured"]
    assert not np.isfinite(phase[frequency < 200.0]).any()
    assert np.isfinite(phase).sum() == len(quiet.frequency) - 50


def test_the_nyquist_plane_follows_both_cursors_and_what_is_laid_over(window: RecordedWindow) -> None:
    page = frf_page(window)
    window.cursors.temperature, window.cursors.frequency = 10.0, 304.0
    drawn, h = curves(page.nyquist), page._frf.h[1, 0]
    line = int(np.abs(page._frf.frequency - 304.0).argmin())
    assert (drawn["cursor"][0][0], drawn["cursor"][1][0]) == (h[line].real, h[line].imag)
    size = np.hypot(*drawn["measured"])
    assert size.max() == pytest.approx(np.abs(h[line - 10 : line + 10]).max())
    rebuilt = np.hypot(*drawn["from poles and residues"])
    assert rebuilt.max() == pytest.approx(size.max(), rel=1e-3)
    assert np.hypot(*drawn["updated twin"]).max() == pytest.approx(1.01 * size.max())
    assert page.nyquist.labels == ("real part [V/V]", "imaginary part [V/V]")
    page.choices.overlays["updated twin"].setChecked(False)
    page.choices.overlays["from poles and residues"].setChecked(False)
    assert set(curves(page.nyquist)) == {"measured", "cursor"}
    window.cursors.temperature = 20.0
    assert curves(page.nyquist)["cursor"][0][0] == page._frf.h[2, 0, line].real


def test_poles_and_residues_are_drawn_in_the_band_that_was_identified(
    shown: Callable[[Any], Any], run: Path
) -> None:
    found = load_modes(run / "modes.h5")
    cut = tuple(replace(modes, band=(100.0, 600.0)) for modes in found.modes)
    save_modes(run / "modes.h5", replace(found, modes=cut), MADE)
    window = shown(RecordedWindow(viewed(run), LIGHT))
    page = frf_page(window)
    for name in ("from poles and residues", "updated twin"):
        frequency, level = curves(page.cut.above)[name]
        known = frequency[np.isfinite(level)]
        assert (known[0], known[-1]) == (100.0, 600.0 if name == "from poles and residues" else 898.0)
    assert page.cut.above.plotItem.titleLabel.text.endswith("identified from 100 to 600 Hz")
    window.cursors.frequency = 800.0
    along = curves(page._along_t)
    assert np.isfinite(along["measured"][0]).all()
    assert not np.isfinite(along["from poles and residues"][0]).any()
    page.grab()
    page.choices.overlays["from poles and residues"].setChecked(False)
    assert page.cut.above.plotItem.titleLabel.text.endswith("on the way up")


def test_a_good_coherence_is_not_drawn_as_a_bad_one(window: RecordedWindow) -> None:
    """That of this run is 0.999 everywhere."""
    chart = frf_page(window).cut.coherence
    for _ in range(2):
        low, high = chart.viewRange()[1]
        assert (low, high) == pytest.approx((0.0, 1.0), abs=0.1)
        assert low <= 0.0
        assert high >= 1.0
        window.reset()


def test_the_coherence_has_the_frequencies_of_the_cut_above(window: RecordedWindow, qtbot: Any) -> None:
    page = frf_page(window)
    page._waterfall.setXRange(300.0, 400.0, padding=0.0)
    for chart in (page.cut.above, page.cut.below, page.cut.coherence):
        np.testing.assert_allclose(chart.viewRange()[0], [300.0, 400.0], atol=3.0)
