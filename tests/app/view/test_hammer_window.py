"""The window on a hammer test: what came of the last hit, in its colour, and which hit is wanted next."""

from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("PySide6.QtSvg", reason="Qt cannot be loaded here", exc_type=ImportError)

from app.files.acquisition.events import append_event, read_events
from app.view.application import application
from app.view.folder import viewed
from app.view.live.hammer_window import HammerWindow
from app.view.opening import window_of
from app.view.screenshots import screenshots
from app.view.theme import DARK, LIGHT
from app.watch.watched_hits import WatchedHits
from drivers.hammer.campaign import Key
from tests.app.hammer_bench import acquire, experiment


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Record a test of nine points, stopped at the fourth."""
    made = tmp_path_factory.mktemp("hammer") / "hits"
    declared = experiment(double_hits=0.0, overloads=0.0)
    keys: Iterator[Key | None] = iter(["stop"])
    declared = declared.model_copy(update={"hammer": declared.hammer.model_copy(update={"hits": 2})})
    acquire(declared, made, lambda: next(keys, None) if len(list((made / "hits").glob("*.h5"))) == 7 else None)
    return made


def test_it_shows_the_last_hit_and_the_next(folder: Path) -> None:
    application()
    window = window_of(viewed(folder), None, LIGHT)
    assert isinstance(window, HammerWindow)
    assert window.banner.text().startswith("ACCEPTED, point 4: ")
    assert LIGHT.corrected in window.banner.styleSheet()
    assert window.asked.text() == "next: point 4 of 9, hit 2 of 2"
    assert (window.bar.value(), window.bar.maximum()) == (7, 18)
    force = window.force._line.getData()[1]
    last = [event for event in read_events(folder) if event["event"] == "hit"][-1]
    assert force.max() == pytest.approx(last["peak"], rel=0.01)
    assert len(window.points._points.data) == 9
    window.change_theme()
    assert DARK.corrected in window.banner.styleSheet()


def test_a_rejected_hit_is_red_with_its_reason(folder: Path) -> None:
    application()
    window = HammerWindow(WatchedHits(folder), LIGHT)
    event = {"step": 99, "set_point": 0, "point": 3, "peak": 12.3, "why": "double hit: 40 % of the force again"}
    append_event(folder, {"event": "hit rejected", "time": 99.0, "date": "2000-01-01T00:02:00+00:00", **event})
    window.look()
    assert window.banner.text() == "REJECTED, point 4: 12.3 N: double hit: 40 % of the force again"
    assert LIGHT.warning in window.banner.styleSheet()
    assert "00:02:00 simulated  hit of point 4 rejected" in window.log.toPlainText()
    append_event(folder, {"event": "hit undone", "step": 6, "set_point": 0, "point": 3})
    window.look()
    assert window.asked.text() == "next: point 4 of 9, hit 1 of 2"


def test_a_picture_of_it(folder: Path, tmp_path: Path) -> None:
    application()
    window = HammerWindow(WatchedHits(folder), LIGHT)
    (picture,) = screenshots(window, tmp_path, lambda stage, share: None)
    assert picture.name == "view-hammer-light.png"
    assert picture.stat().st_size > 10_000


def test_a_damaged_log_is_told_and_does_not_stop_it(folder: Path) -> None:
    application()
    window = HammerWindow(WatchedHits(folder), LIGHT)
    whole = (folder / "events.jsonl").read_bytes()
    try:
        (folder / "events.jsonl").write_bytes(b"{damaged\n" + whole)
        window.look()
        assert "events.jsonl" in window.statusBar().currentMessage()
    finally:
        (folder / "events.jsonl").write_bytes(whole)
    window.look()
    assert window.statusBar().currentMessage() == ""
