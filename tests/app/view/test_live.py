"""The live window on campaigns that a simulated rig is acquiring in another thread."""

import json
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import butter, sosfilt

pytest.importorskip("PySide6.QtSvg", reason="Qt cannot be loaded here", exc_type=ImportError)

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QMessageBox

from app.files.acquisition.campaign_folder import campaign_log
from app.files.acquisition.events import LatestRepeat, requested, save_latest
from app.files.campaigns.folder import Source, sweep_paths
from app.files.campaigns.loading import load_campaign
from app.files.declarations.experiment import AcquiredExperiment, read_acquired_experiment
from app.stages.acquire import acquire_campaign
from app.view.application import application
from app.view.folder import Viewed
from app.view.live.window import LiveWindow
from app.view.opening import window_of
from app.view.recorded.window import RecordedWindow
from app.view.theme import DARK, LIGHT
from app.watch.watched import Watched
from drivers.ni.modules import NI_9211, NI_9234, NI_9260
from drivers.rig.campaign import Outcome, unobserved
from drivers.rig.end_requests import RigStopped
from drivers.rig.session import Session
from drivers.rig.simulated import SimulatedParts, simulated_parts

EXAMPLE = Path(__file__).resolve().parents[3] / "examples" / "simulated-rig.toml"
WAIT = 300_000
"""Milliseconds; a busy machine is no failure."""


class Acquisition:
    """A campaign of six set-points in a thread; a sweep takes `pace` seconds of ours."""

    def __init__(self, folder: Path, pace: float = 0.02) -> None:
        self.folder, self.pace = folder, pace
        example = read_acquired_experiment(EXAMPLE)
        programme = example.programme.model_copy(
            update={
                "lowest": 24.0,
                "highest": 34.0,
                "every": 2.0,
                "ramp_rate": 2.0,
                "lead": 2.0,
                "soak_before": 60.0,
            }
        )
        sweep = example.sweep.model_copy(update={"duration": 0.5, "taper": 0.05, "tail": 0.2})
        self.experiment: AcquiredExperiment = example.model_copy(update={"programme": programme, "sweep": sweep})
        self.outcome: Outcome | None = None
        self.stopped: RigStopped | None = None
        self.parts: SimulatedParts | None = None
        self._thread = threading.Thread(target=self.run, daemon=True)

    def plate(self, drive: NDArray[Any], rate: float, temperature: NDArray[Any]) -> NDArray[np.float64]:
        time.sleep(self.pace)
        centre = 600.0 * (1.0 - 0.01 * (float(temperature.mean()) - 20.0))
        band = butter(1, [0.95 * centre, 1.05 * centre], btype="bandpass", fs=rate, output="sos")
        return np.asarray(0.5 * sosfilt(band, drive))[None]

    def run(self) -> None:
        experiment = self.experiment
        modules = {1: NI_9234, 2: NI_9260, 3: NI_9211}
        self.parts = simulated_parts(experiment.cards, experiment.oven, self.plate, modules=modules, seed=3)
        source = Source("mine.toml", "0" * 64)
        acquired = {**experiment.model_dump(mode="json"), "rig": "simulated"}
        session = Session(self.parts.rig(), experiment.limits, campaign_log(self.folder))
        try:
            self.outcome = acquire_campaign(session, experiment, self.folder, source, acquired, unobserved)
        except RigStopped as stopped:
            self.stopped = stopped

    def start(self) -> "Acquisition":
        self._thread.start()
        while not (self.folder / "events.jsonl").is_file():
            time.sleep(0.01)
        return self

    def finish(self) -> None:
        self._thread.join(300.0)
        assert not self._thread.is_alive()


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    acquisition = Acquisition(tmp_path_factory.mktemp("finished") / "campaign", pace=0.0)
    acquisition.run()
    return acquisition.folder


@pytest.fixture
def opened(shown: Callable[[Any], Any]) -> Callable[[Path], LiveWindow]:
    def show(folder: Path) -> LiveWindow:
        application()
        window: LiveWindow = shown(LiveWindow(Watched(folder), LIGHT))
        return window

    return show


def test_a_campaign_is_paused_taken_up_and_watched_to_its_end(
    opened: Callable[[Path], LiveWindow], tmp_path: Path, qtbot: Any
) -> None:
    acquisition = Acquisition(tmp_path / "campaign", pace=0.05).start()
    window = opened(acquisition.folder)
    qtbot.waitUntil(lambda: window.badge.text() == "RUNNING" and len(window.frfs.curves) >= 1, timeout=WAIT)
    qtbot.mouseClick(window.pause, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: window.badge.text() == "PAUSED", timeout=WAIT)
    before = len(sweep_paths(acquisition.folder))
    assert window.windowTitle() == f"campaign – paused, {before} of 6 sweeps – Flexura"
    qtbot.wait(800)
    assert len(sweep_paths(acquisition.folder)) == before < 6
    assert window.pause.text() == "Continue"
    qtbot.keyClick(window, Qt.Key.Key_P)
    qtbot.waitUntil(lambda: window.badge.text() == "COMPLETE", timeout=WAIT)
    acquisition.finish()
    assert acquisition.outcome is not None
    assert (acquisition.outcome.finished, acquisition.outcome.missing) == (6, 0)
    qtbot.waitUntil(lambda: len(window.frfs.curves) == 6, timeout=WAIT)
    assert window.bar.value() == 6
    assert window.windowTitle() == "campaign – complete, 6 of 6 sweeps – Flexura"
    for words in ("paused", "continued", "finished: 34 °C up 1 V"):
        assert words in window.log.toPlainText()
    assert not window.stop.isEnabled()
    campaign = load_campaign(acquisition.folder)
    assert [round(s.temperature) for s in campaign.sweeps] == [24, 26, 28, 30, 32, 34]


def test_a_stop_brings_all_to_rest_and_the_campaign_goes_on_later(
    opened: Callable[[Path], LiveWindow], tmp_path: Path, qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    acquisition = Acquisition(tmp_path / "campaign", pace=0.05).start()
    window = opened(acquisition.folder)
    answers = iter([QMessageBox.StandardButton.No, QMessageBox.StandardButton.Yes])
    monkeypatch.setattr(QMessageBox, "question", lambda *_: next(answers))
    qtbot.waitUntil(lambda: window.badge.text() == "RUNNING" and window.bar.value() >= 1, timeout=WAIT)
    window.ask_and_stop()
    assert requested(acquisition.folder) == "go on"
    qtbot.keyClick(window, Qt.Key.Key_S, Qt.KeyboardModifier.ControlModifier)
    qtbot.waitUntil(lambda: window.badge.text() == "STOPPED", timeout=WAIT)
    acquisition.finish()
    assert acquisition.stopped is not None
    assert "flexura view" in str(acquisition.stopped)
    assert acquisition.parts is not None
    assert acquisition.parts.server.output_voltage() == 0.0
    assert not acquisition.parts.body.regulating
    assert requested(acquisition.folder) == "go on"
    again = Acquisition(acquisition.folder, pace=0.0)
    again.run()
    assert again.outcome is not None
    assert again.outcome.finished + again.outcome.missing == 6
    assert again.outcome.finished > again.outcome.made_now


def test_closing_the_window_does_nothing_to_the_campaign(
    opened: Callable[[Path], LiveWindow], tmp_path: Path, qtbot: Any
) -> None:
    acquisition = Acquisition(tmp_path / "campaign").start()
    window = opened(acquisition.folder)
    qtbot.waitUntil(lambda: window.badge.text() == "RUNNING", timeout=WAIT)
    window.close()
    acquisition.finish()
    assert acquisition.outcome is not None
    assert acquisition.outcome.finished == 6


def test_the_last_repeat_is_shown_with_levels_and_clip_marks(
    opened: Callable[[Path], LiveWindow], finished: Path, tmp_path: Path, qtbot: Any
) -> None:
    window = opened(finished)
    channels = ("drive", "S1")
    time_axis = np.arange(4000) / 8000.0
    loud = np.stack([np.sin(2 * np.pi * 100.0 * time_axis), 5.0 * np.sin(2 * np.pi * 400.0 * time_axis)])
    latest = LatestRepeat(
        step=2,
        repeat=1,
        place="28 °C up 1 V",
        channels=channels,
        signals=loud.astype(np.float32),
        overloaded=np.array([False, True]),
        sample_rate=8000.0,
        full_scale=5.0,
    )
    before = (finished / "latest.h5").read_bytes()
    try:
        save_latest(finished, latest)
        qtbot.waitUntil(lambda: window.levels.clipped == [False, True], timeout=WAIT)
        ((_, _, levels),) = window.levels.curves
        assert levels.tolist() == pytest.approx([20 * np.log10(0.2), 0.0], abs=1e-3)
        spectrum = {label: (x, y) for label, x, y in window.spectrum.curves}
        for name, frequency, volts in (("drive", 100.0, 1.0), ("S1", 400.0, 5.0)):
            x, y = spectrum[name]
            assert x[y.argmax()] == pytest.approx(frequency)
            assert y.max() == pytest.approx(20 * np.log10(volts), abs=1e-3)
        assert "repeat 2 of 28 °C up 1 V" in window.signals.plotItem.titleLabel.text
    finally:
        (finished / "latest.h5").write_bytes(before)


def test_temperatures_set_point_and_sweeps_stand_in_the_chart(
    opened: Callable[[Path], LiveWindow], finished: Path, qtbot: Any
) -> None:
    window = opened(finished)
    curves = {label: (x, y) for label, x, y in window.oven.curves}
    assert {"programme", "set-point", "air", "plate", "finished", "asked for"} <= set(curves)
    assert curves["finished"][1] == pytest.approx([24, 26, 28, 30, 32, 34], abs=0.4)
    assert curves["asked for"][1].tolist() == [24.0, 26.0, 28.0, 30.0, 32.0, 34.0]
    at, set_point = curves["set-point"]
    on_ramp = np.interp(curves["air"][0], at, set_point)
    lag = np.nanmedian(np.abs(on_ramp - curves["air"][1]))
    assert lag < 1.0
    assert np.nanmax(set_point) == pytest.approx(36.0, abs=1e-6)


def test_damage_is_told_and_everything_else_is_shown(
    opened: Callable[[Path], LiveWindow], finished: Path, tmp_path: Path, qtbot: Any
) -> None:
    import shutil

    folder = tmp_path / "damaged"
    shutil.copytree(finished, folder)
    victim = sweep_paths(folder)[2]
    victim.write_bytes(victim.read_bytes()[:3000])
    (folder / "latest.h5").write_bytes(b"none")
    with (folder / "events.jsonl").open("a", encoding="utf-8") as file:
        file.write("no event\n" + json.dumps({"event": "undated"}) + "\n" + '{"event": "torn')
    with (folder / "readings.csv").open("a", encoding="utf-8") as file:
        file.write("2000-01-01T00:00:00+00:00,not,a\n")
    window = opened(folder)
    qtbot.waitUntil(lambda: len(window.frfs.curves) == 5, timeout=WAIT)
    said = window.statusBar().currentMessage()
    assert victim.name in said
    assert "events.jsonl" in said
    assert window.badge.text() == "COMPLETE"
    window.change_theme()
    assert window.theme is DARK
    assert len(window.frfs.curves) == 5


def test_a_runner_that_is_gone_is_called_silent(finished: Path, tmp_path: Path) -> None:
    folder = tmp_path / "killed"
    folder.mkdir()
    (folder / "protocol.json").write_bytes((finished / "protocol.json").read_bytes())
    lines = (finished / "events.jsonl").read_text(encoding="utf-8").splitlines(keepends=True)
    (folder / "events.jsonl").write_text("".join(lines[:4]), encoding="utf-8")
    watched = Watched(folder)
    watched.look()
    now = (folder / "events.jsonl").stat().st_mtime
    assert watched.state(now + 5.0) == "running"
    assert watched.state(now + 3600.0) == "silent"


def test_the_window_that_fits_is_opened(finished: Path, run: Path, qtbot: Any) -> None:
    application()
    for viewed, kind, expected in (
        (Viewed(finished, None), None, LiveWindow),
        (Viewed(finished, run), None, RecordedWindow),
        (Viewed(finished, run), "live", LiveWindow),
        (Viewed(None, run), None, RecordedWindow),
    ):
        window = window_of(viewed, kind, LIGHT)  # type: ignore[arg-type]
        qtbot.addWidget(window)
        assert isinstance(window, expected)
    with pytest.raises(ValueError, match="nothing is live"):
        window_of(Viewed(None, run), "live", LIGHT)
