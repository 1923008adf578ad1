"""The window on a modal test, driven as a hand would."""

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("PySide6.QtSvg", reason="Qt cannot be loaded here", exc_type=ImportError)

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QMessageBox

from analysis.estimation.transfer import MeasuredTransfer
from analysis.identification.over_temperature.tracked_modes import TrackedModes
from app.files.bad_file import ResultFileError
from app.files.campaigns.inputs import origin_of_result
from app.files.provenance import provenance
from app.files.results.laws_file import load_laws, load_updated, save_laws
from app.files.results.modes_file import load_modes, load_shapes, save_modes
from app.files.uff.frfs import write_frfs
from app.modal_test.edits import edits_of
from app.modal_test.modes_of_test import MODE_HEADINGS
from app.view.application import application
from app.view.folder import viewed
from app.view.opening import open_beside, window_of
from app.view.screenshots import screenshots
from app.view.test_run.compared_page import ComparedPage
from app.view.test_run.window import TestWindow
from app.view.theme import DARK, LIGHT
from app.view.twin_page import TwinPage
from tests.app.modal_test.conftest import Beam, F, typed
from tests.app.view.conftest import MADE
from tests.app.view.test_twin_page import record as pairing_of_test_and_twin


@pytest.fixture(scope="module")
def identified(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Run folder of four accelerances of a beam, identified."""
    folder, rng = tmp_path_factory.mktemp("beam"), np.random.default_rng(0)
    frequency = np.arange(40.0, 700.0, 0.5)
    frfs = []
    for i in range(4):
        h = Beam().frf(frequency, i, 0, 2)
        h = h + 1e-3 * np.abs(h).max() * (rng.normal(size=h.shape) + 1j * rng.normal(size=h.shape))
        frfs.append(MeasuredTransfer(f"point {i + 1}", f"{i + 1}:+3", "1:+3", "acceleration", frequency, h))
    write_frfs(folder / "beam.uff", frfs)
    assert (
        typed("identify", folder / "beam.uff", "--shared-poles", "--out", folder / "run", "--quiet").exit_code == 0
    )
    return folder / "run"


@pytest.fixture
def window(identified: Path, tmp_path: Path, shown: Callable[[Any], Any]) -> TestWindow:
    application()
    run = shutil.copytree(identified, tmp_path / "run")
    opened: TestWindow = shown(window_of(viewed(run), None, LIGHT))
    assert isinstance(opened, TestWindow)
    return opened


def cells(window: TestWindow, column: int) -> list[str]:
    table = window.modes.table
    return [item.text() for row in range(table.rowCount()) if (item := table.item(row, column)) is not None]


def test_the_table_tells_every_mode_with_its_status(window: TestWindow) -> None:
    assert [float(text) for text in cells(window, 0)] == pytest.approx(list(F), rel=1e-3)
    assert cells(window, 5) == ["kept, confirmed"] * 3
    assert all("found again" in text for text in cells(window, 6))


def test_it_fits_a_small_screen(window: TestWindow) -> None:
    assert (window.width(), window.height()) == (1280, 800)
    assert window.minimumSizeHint().width() <= 1280
    assert window.minimumSizeHint().height() <= 800


@pytest.mark.parametrize("lines", [0, 10, -400])
def test_the_nyquist_plane_shows_its_whole_circle_wherever_the_cursor_goes(window: TestWindow, lines: int) -> None:
    window.frfs.axis.step(lines)
    shown = window.frfs.nyquist.getViewBox().viewRange()
    for (low, high), values in zip(shown, window.frfs.nyquist.curves[1][1:], strict=True):
        assert low <= np.min(values)
        assert np.max(values) <= high


def test_the_reading_at_the_cursor_has_its_unit(window: TestWindow) -> None:
    assert " m/s2/N</td>" in window.frfs.readout.text()


def test_selecting_a_mode_moves_cursor_and_shape(window: TestWindow) -> None:
    window.tabs.setCurrentIndex(1)
    window.modes.table.selectRow(0)
    window.modes.step(1)
    assert window.cursors.frequency == pytest.approx(F[1], rel=1e-3)
    _, _, motion = window.modes.shape.curves[0]
    np.testing.assert_allclose(motion, window.held.shapes.shape[1].real)
    assert window.modes.shape.plotItem.titleLabel.text.startswith("shape at 26")


def test_parts_and_logarithmic_frequencies(window: TestWindow) -> None:
    page, h = window.frfs, window.held.frfs.h
    page.choice.setCurrentIndex(2)
    page.display.setCurrentIndex(1)
    page.axis.setChecked(True)
    label, x, y = page.above.curves[0]
    assert label == "measured"
    np.testing.assert_allclose(x, window.held.frfs.frequency)  # as exported, in Hz
    np.testing.assert_allclose(y, h[2].real)
    np.testing.assert_allclose(page.below.curves[0][2], h[2].imag)
    before = page.axis.line
    page.axis.step(10)
    assert page.axis.line == before + 10
    page.rebuilt.setChecked(False)
    assert [one[0] for one in page.above.curves] == ["measured"]


def test_differences_are_told_from_the_mark(window: TestWindow) -> None:
    page, frfs = window.frfs, window.held.frfs
    window.cursors.frequency = 100.0
    page.mark()
    window.cursors.frequency = 150.0
    there, here = (abs(frfs.h[0][np.abs(frfs.frequency - f).argmin()]) for f in (100.0, 150.0))
    assert "+50.0000 Hz" in page.readout.text()
    assert f"{20 * np.log10(here / there):+.2f} dB" in page.readout.text()


def test_the_nyquist_plane_shows_the_peak_nearest_to_the_cursor(window: TestWindow) -> None:
    window.cursors.frequency = float(F[0])
    measured = {label: (x, y) for label, x, y in window.frfs.nyquist.curves}["measured"]
    assert window.frfs.nyquist.labels == ("real part [m/s2/N]", "imaginary part [m/s2/N]")
    size = np.hypot(*measured)
    near = np.abs(window.held.frfs.frequency - F[0]) < 3.0
    assert size.max() == pytest.approx(np.abs(window.held.frfs.h[0][near]).max())


@pytest.fixture
def answers(monkeypatch: pytest.MonkeyPatch) -> list[QMessageBox.StandardButton]:
    """Answers to the questions that follow, the next one last."""
    given: list[QMessageBox.StandardButton] = []
    monkeypatch.setattr(QMessageBox, "question", lambda *_: given.pop())
    return given


def test_a_mode_is_dropped_after_a_question_and_comes_back_by_undo(
    window: TestWindow, answers: list[QMessageBox.StandardButton], qtbot: Any
) -> None:
    before = (window.held.run / "modes.h5").read_bytes()
    window.tabs.setCurrentIndex(1)
    window.modes.table.selectRow(1)
    answers.append(QMessageBox.StandardButton.No)
    window.modes.dropping.click()
    assert (window.held.run / "modes.h5").read_bytes() == before
    assert not window.modes.undoing.isEnabled()
    place = window.modes.dropping.mapTo(window, window.modes.dropping.rect().topLeft())
    answers.append(QMessageBox.StandardButton.Yes)
    window.modes.dropping.click()
    qtbot.waitUntil(lambda: window.modes.dropping.isVisible())
    assert window.modes.table.rowCount() == 2
    assert window.modes.dropping.mapTo(window, window.modes.dropping.rect().topLeft()) == place
    assert "dropped by hand" in window.modes.undoing.toolTip()
    qtbot.keyClick(window, Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert "undone: mode at 26" in window.statusBar().currentMessage()
    assert (window.held.run / "modes.h5").read_bytes() == before
    assert window.modes.table.rowCount() == 3
    window.modes.redoing.click()
    assert window.modes.table.rowCount() == 2


def test_the_table_is_copied_whole(window: TestWindow, qtbot: Any) -> None:
    window.tabs.setCurrentIndex(1)
    window.modes.table.setFocus()
    qtbot.keyClick(window.modes.table, Qt.Key.Key_C, Qt.KeyboardModifier.ControlModifier)
    rows = [line.split("\t") for line in QApplication.clipboard().text().splitlines()]
    assert rows[0] == list(MODE_HEADINGS)
    assert [float(row[0]) for row in rows[1:]] == pytest.approx(list(F), rel=1e-3)
    assert {len(row) for row in rows} == {len(MODE_HEADINGS)}


def test_a_mode_dropped_and_added_from_the_window_is_recorded(
    window: TestWindow, answers: list[QMessageBox.StandardButton]
) -> None:
    window.modes.table.selectRow(1)
    answers.append(QMessageBox.StandardButton.Yes)
    window.modes.dropping.click()
    assert window.modes.table.rowCount() == 2
    assert "dropped by hand" in window.statusBar().currentMessage()
    window.cursors.frequency = 263.0
    window.modes.adding.click()
    assert [float(text) for text in cells(window, 0)] == pytest.approx(list(F), rel=1e-3)
    assert [edit.split()[-3] for edit in edits_of(window.held.run)] == ["dropped", "added"]


def test_other_folders_are_opened_and_pages_pictured(window: TestWindow, tmp_path: Path) -> None:
    other = open_beside(window, window.held.run)
    assert isinstance(other, TestWindow)
    other.close()
    with pytest.raises(ResultFileError, match="does not exist"):
        open_beside(window, tmp_path / "nowhere")
    window.folder_chosen.emit(window, tmp_path / "nowhere")
    assert "does not exist" in window.statusBar().currentMessage()
    window.change_theme()
    assert window.theme is DARK
    names = [path.name for path in screenshots(window, tmp_path / "pictures", lambda *_: None)]
    assert names == ["view-test-frfs-dark.png", "view-test-modes-dark.png"]


def test_nothing_is_live_in_a_test(identified: Path) -> None:
    application()
    with pytest.raises(ResultFileError, match="nothing is live in it"):
        window_of(viewed(identified), "live", LIGHT)


def test_frequencies_are_read_as_was_chosen(identified: Path, tmp_path: Path, shown: Callable[[Any], Any]) -> None:
    run, heavy = shutil.copytree(identified, tmp_path / "run"), replace_damping(identified)
    save_modes(run / "modes.h5", heavy, provenance({}), load_shapes(identified / "modes.h5"))
    application()
    window = shown(window_of(viewed(run), None, LIGHT))
    assert [float(text) for text in cells(window, 0)] == pytest.approx(list(F), rel=2e-3)
    window.modes.table.selectRow(1)
    assert window.cursors.frequency == pytest.approx(F[1], rel=2e-3)


def replace_damping(identified: Path) -> TrackedModes:
    """Modes of the same |pole| with a damping ratio of 20 %, read as viscous."""
    tracked = load_modes(identified / "modes.h5")
    (modes,) = tracked.modes
    heavy = replace(modes, poles=np.abs(modes.poles) * complex(-0.2, np.sqrt(1.0 - 0.04)))
    return replace(tracked, modes=(heavy,)).read_as("viscous")


def test_the_axes_of_the_auto_mac_give_number_and_frequency(window: TestWindow) -> None:
    for side in ("bottom", "left"):
        (names, _) = window.modes.alike.getAxis(side)._tickLevels
        assert [text for _, text in names] == [f"{n}: {f:.0f}" for n, f in enumerate(F, start=1)]
        assert "f [Hz]" in window.modes.alike.getAxis(side).labelText


def test_a_shape_moves_on_a_wire_frame(laser: TestWindow, qtbot: Any) -> None:
    """Twelve points of a plate; half a turn later the shape is upside down."""
    page = laser.modes
    laser.tabs.setCurrentIndex(1)
    assert page.moving.isVisible()
    page.play_or_stop()
    page.table.selectRow(1)
    before = page.moving.motion
    assert np.abs(before).max() == pytest.approx(1.0, abs=1e-3)
    assert np.abs(before[:, :2]).max() == 0.0
    page.moving.turn(np.pi)
    np.testing.assert_allclose(page.moving.motion, -before, atol=1e-12)
    phase = page.moving.motion
    page.play_or_stop()
    qtbot.waitUntil(lambda: not np.allclose(page.moving.motion, phase))
    page.shown_as.setCurrentIndex(1)
    assert page.shape.isVisible()
    assert not page.moving.isVisible()


def test_others_are_drawn_behind_an_frf_and_its_drive_point_is_judged(laser: TestWindow) -> None:
    page = laser.frfs
    assert [label for label, _, _ in page.above.curves] == ["measured", "rebuilt"]
    assert page.checked.text().startswith("drive point: takes power")
    page.beside.setCurrentIndex(1)
    assert len(page.above.curves) == 2 + 11
    page.beside.setCurrentIndex(4)
    assert len(page.above.curves) == 3
    np.testing.assert_allclose(page.above.curves[2][2], 20 * np.log10(np.abs(laser.held.frfs.h[2])), rtol=1e-6)
    page.choice.setCurrentIndex(1)
    assert page.checked.text() == ""


def test_modes_of_two_runs_are_set_side_by_side(laser: TestWindow, tmp_path: Path) -> None:
    laser.compare(laser.held.run)
    assert isinstance(laser.compared, ComparedPage)
    table = laser.compared.table
    assert laser.tabs.tabText(laser.tabs.currentIndex()) == "Compared"
    rows = [[table.item(n, c).text() for c in range(table.columnCount())] for n in range(table.rowCount())]
    assert [float(row[2]) for row in rows] == pytest.approx([0.0] * len(rows))
    assert [float(row[5]) for row in rows] == pytest.approx([1.0] * len(rows))
    assert len(laser.compared.alike._written) == len(rows) ** 2
    with pytest.raises(ResultFileError):
        laser.compare(tmp_path)


def test_the_twin_of_a_plate_is_set_beside_a_test(laser: TestWindow, run: Path) -> None:
    with pytest.raises(ResultFileError, match="holds no modes to be compared"):
        laser.compare(run)
    laws, (found, twin) = load_laws(run / "laws.h5"), load_updated(run / "laws.h5")
    save_laws(run / "laws.h5", found, laws, twin, MADE, pairing_of_test_and_twin())
    laser.compare(run)
    assert laser.tabs.tabText(laser.tabs.currentIndex()) == "Twin"
    assert isinstance(laser.compared, TwinPage)
    assert "other recordings than this test's" in laser.compared.said.text()
    inputs = origin_of_result(laser.held.run / "transfers.h5", "identify").inputs
    save_laws(run / "laws.h5", found, laws, twin, provenance(inputs), pairing_of_test_and_twin())
    laser.compare(run)
    assert isinstance(laser.compared, TwinPage)
    assert "updated with the recordings of this test" in laser.compared.said.text()


@pytest.fixture(scope="module")
def plate_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Run folder of twelve accelerances over a plate with half-waves along x and y."""
    folder, rng = tmp_path_factory.mktemp("plate"), np.random.default_rng(1)
    frequency = np.arange(40.0, 400.0, 0.5)
    points = {1 + i + 4 * j: (0.05 + 0.08 * i, 0.04 + 0.07 * j, 0.0) for i in range(4) for j in range(3)}
    natural, w = 2.0 * np.pi * np.array([90.0, 180.0, 260.0]), 2.0 * np.pi * frequency
    shapes = np.array(
        [
            [np.sin(np.pi * m * x / 0.34) * np.sin(np.pi * n * y / 0.22) for x, y, _ in points.values()]
            for m, n in ((1, 1), (2, 1), (1, 2))
        ]
    )
    frfs = []
    for k, node in enumerate(points):
        h = sum(
            a[k] * a[0] * -(w**2) / (o**2 - w**2 + 0.02j * o * w) for a, o in zip(shapes, natural, strict=True)
        )
        h = h + 1e-3 * np.abs(h).max() * (rng.normal(size=h.shape) + 1j * rng.normal(size=h.shape))
        frfs.append(MeasuredTransfer(f"point {node}", f"{node}:+3", "1:+3", "acceleration", frequency, h))
    write_frfs(folder / "plate.uff", frfs, points=points)
    found = typed("identify", folder / "plate.uff", "--shared-poles", "--out", folder / "run", "--quiet")
    assert found.exit_code == 0, found.stderr
    return folder / "run"


@pytest.fixture
def laser(plate_run: Path, tmp_path: Path, shown: Callable[[Any], Any]) -> TestWindow:
    application()
    opened: TestWindow = shown(window_of(viewed(shutil.copytree(plate_run, tmp_path / "run")), None, LIGHT))
    return opened
