"""A verb whose results do not go onto the disk says so in one message, and leaves what was there."""

import errno
import os
import shutil
import wave
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.stages import health
from tests.app.conftest import SmallRun, TinyCampaign
from tests.app.corrected_run import write_run
from tests.app.test_health import report as judged

Flexura = Callable[..., tuple[int, str, str]]


@pytest.fixture
def full(monkeypatch: pytest.MonkeyPatch) -> Callable[[int], None]:
    """Return a function that lets the disk be full (or whatever `error` says) when bytes are forced to it."""

    def fill(error: int) -> None:
        def refuse(_: int) -> None:
            raise OSError(error, os.strerror(error))

        monkeypatch.setattr(os, "fsync", refuse)

    return fill


def listed(folder: Path) -> dict[str, bytes]:
    return {str(one.relative_to(folder)): one.read_bytes() for one in folder.rglob("*") if one.is_file()}


def refused(answer: tuple[int, str, str], named: str, error: int = errno.ENOSPC) -> None:
    status, out, err = answer
    assert status == 2, err
    assert out == ""
    (message,) = [line for line in err.splitlines() if line.startswith("Error: ")]
    assert named in message
    assert os.strerror(error) in message
    assert "Traceback" not in err


VERBS: dict[str, tuple[tuple[str, ...], str]] = {
    "focus": (("focus", "RUN", "--panel", "PANEL"), "filters.h5"),
    "compensate": (("compensate", "RUN", "--panel", "PANEL"), "compensation.h5"),
    "export to C": (("export", "RUN", "--to", "c"), "OUT"),
    "export to npz": (("export", "RUN", "--to", "npz"), "OUT"),
    "export to WAV": (("export", "RUN", "--to", "wav"), "OUT"),
    "export to CSV": (("export", "RUN", "--to", "csv"), "OUT"),
}


@pytest.mark.parametrize("verb", VERBS)
@pytest.mark.parametrize("error", [errno.ENOSPC, errno.EROFS, errno.EIO])
def test_results_of_a_panel(
    verb: str, error: int, small_run: SmallRun, tmp_path: Path, run_flexura: Flexura, full: Callable[[int], None]
) -> None:
    run, out = tmp_path / "run", tmp_path / "out"
    shutil.copytree(small_run.folder, run)
    out.mkdir()
    words, named = VERBS[verb]
    # filters that cannot be read are refused before anything is compensated
    there = {name: b"old" for name in ("filters.h5", "compensation.h5") if verb != "compensate" or name == named}
    for name, content in there.items():
        (out / name).write_bytes(content)
    known = {"RUN": run, "PANEL": small_run.panel, "OUT": out}
    full(error)
    answer = run_flexura(*(known.get(word, word) for word in words), "--out", out)
    refused(answer, str(known.get(named, named)), error)
    assert listed(out) == there


def test_an_import_and_an_identification(
    tiny: TinyCampaign, tmp_path: Path, run_flexura: Flexura, full: Callable[[int], None]
) -> None:
    recording = tiny.write(tmp_path / "recording")
    status, _, said = run_flexura("import", recording, "--out", tmp_path / "campaign")
    assert status == 0, said
    full(errno.ENOSPC)
    refused(run_flexura("import", recording, "--out", tmp_path / "again"), "protocol.json")
    refused(run_flexura("identify", tmp_path / "campaign", "--out", tmp_path / "run"), "frf.h5")
    assert {one.name for one in tmp_path.iterdir() if not one.name.endswith(".lock")} == {"campaign", "recording"}
    assert not [name for name in listed(tmp_path) if name.endswith(".part")]


def test_declarations(tmp_path: Path, run_flexura: Flexura, full: Callable[[int], None]) -> None:
    np.savez(tmp_path / "a.npz", fs=1000.0, force=np.ones(99), acc=np.ones(99))
    full(errno.ENOSPC)
    refused(run_flexura("new", "test", tmp_path / "a.npz"), "test.toml")
    assert list(listed(tmp_path)) == ["a.npz"]


def test_a_blind_trial(tmp_path: Path, run_flexura: Flexura, full: Callable[[int], None]) -> None:
    full(errno.ENOSPC)
    refused(run_flexura("blind-trial", "--count", 1, "--seed", 1, "--out", tmp_path / "trial"), "trial.json")
    assert listed(tmp_path) == {}


@pytest.mark.parametrize("pictured", [False, True])
def test_a_judged_panel(
    pictured: bool,
    tmp_path: Path,
    run_flexura: Flexura,
    monkeypatch: pytest.MonkeyPatch,
    full: Callable[[int], None],
) -> None:
    """Judged already; where the picture alone is not written, the judgement that was finished stays."""
    found = health.WatchedPanel(judged(changed=True), (), {})
    monkeypatch.setattr(health, "compute", lambda *_, **__: found)
    run, week = write_run(tmp_path / "run"), write_run(tmp_path / "week")
    (run / "health.json").write_text("old")
    before, save = listed(tmp_path), health.save

    def saved(*given: Any) -> Any:
        record = save(*given)
        full(errno.ENOSPC)
        return record

    if pictured:
        monkeypatch.setattr(health, "save", saved)
    else:
        full(errno.ENOSPC)
    answer = run_flexura("health", week, "--baseline", run, *(["--picture"] if pictured else []))
    refused(answer, "health.png" if pictured else "health.json")
    after = listed(tmp_path)
    assert after.keys() == before.keys()
    assert {name for name in after if after[name] != before[name]} == ({"run/health.json"} if pictured else set())


def room(monkeypatch: pytest.MonkeyPatch, free: float) -> None:
    monkeypatch.setattr(shutil, "disk_usage", lambda _: type("Usage", (), {"free": int(free)}))


def _never(*_: Any, **__: Any) -> None:
    raise AssertionError("computed before the disk was looked at")


@pytest.mark.parametrize("verb", [verb for verb in VERBS if verb != "compensate"])
def test_room_is_looked_for_before_the_work(
    verb: str, small_run: SmallRun, tmp_path: Path, run_flexura: Flexura, monkeypatch: pytest.MonkeyPatch
) -> None:
    words, _ = VERBS[verb]
    known = {"RUN": small_run.folder, "PANEL": small_run.panel}
    room(monkeypatch, 2e6)
    monkeypatch.setattr("app.stages.focus.compute", _never)
    status, _, err = run_flexura(*(known.get(word, word) for word in words), "--out", tmp_path / "out")
    assert status == 2
    assert f"{tmp_path / 'out'}: 2 MB are free on its disk, about 5 MB are needed" in err
    assert not (tmp_path / "out").exists()


def test_room_for_campaigns_and_a_sound(
    tiny: TinyCampaign, small_run: SmallRun, tmp_path: Path, run_flexura: Flexura, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("soundfile")
    recording = tiny.write(tmp_path / "recording")
    rate = 10_240
    with wave.open(str(tmp_path / "sound.wav"), "wb") as sound:
        sound.setnchannels(1)
        sound.setsampwidth(2)
        sound.setframerate(rate)
        sound.writeframes(bytes(2 * rate * 60))
    room(monkeypatch, 5.01e6)
    status, _, err = run_flexura("blind-trial", "--count", 9, "--seed", 1, "--out", tmp_path / "trial")
    assert status == 2
    assert "5.01 MB are free on its disk, about 32 MB are needed" in err
    status, _, err = run_flexura("import", recording, "--out", tmp_path / "campaign")
    assert status == 2
    assert "5.01 MB are free" in err
    status, _, err = run_flexura("render", tmp_path / "sound.wav", small_run.folder, "--temperature", 20)
    assert status == 2, err
    assert "5.01 MB are free" in err or "sampled at" in err


def test_a_cache_that_is_full_is_done_without(
    small_run: SmallRun, tmp_path: Path, run_flexura: Flexura, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "cache").write_text("a file where the folder would be")
    monkeypatch.setenv("FLEXURA_CACHE", str(tmp_path / "cache"))
    words = ("focus", small_run.folder, "--panel", small_run.panel, "--out", tmp_path / "out", "--temperature", 20)
    status, _, err = run_flexura(*words)
    assert status == 0, err
    assert (tmp_path / "out" / "filters.h5").is_file()
