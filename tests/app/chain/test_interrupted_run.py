"""Ctrl-C while ``flexura run`` is at work, as a terminal sends it: finished stages stay whole, status 130."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.app.conftest import TinyCampaign

ROOT = Path(__file__).resolve().parents[3]
Run = Callable[..., tuple[int, str, str]]
WAITING = """
import sys, time
from app.main import main
from app.stages import identify

def wait(*_, **__):
    print("at it", flush=True)
    time.sleep(600.0)

if __name__ == "__main__":
    identify.compute = wait
    main(sys.argv[1:])
"""
SAVING = """
import os, signal, sys
from app.main import main
from app.stages import identify

saved = identify.save

def interrupted(*given):
    os.kill(os.getpid(), signal.SIGINT)
    saved(*given)

if __name__ == "__main__":
    identify.save = interrupted
    main(sys.argv[1:])
"""


@pytest.fixture
def words(tiny: TinyCampaign, tmp_path: Path) -> list[str]:
    """Return what is typed: import and identify, in the quickest way."""
    folder = tiny.write(tmp_path / "tiny")
    return ["run", str(folder), "--until", "identify", "--set", "identify.method=peak-picking"]


def started(script: Path, words: list[str]) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, str(script), *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        text=True,
        start_new_session=True,
    )


def states(run: Path) -> dict[str, str]:
    record = json.loads((run / "run.json").read_text(encoding="utf-8"))
    return {name: stage["state"] for name, stage in record["stages"].items()}


@pytest.mark.skipif(sys.platform == "win32", reason="sends signals to a group of processes")
@pytest.mark.parametrize("to", ["program", "all"])
def test_stages_before_the_one_that_was_stopped_stay(
    words: list[str], tmp_path: Path, run_flexura: Run, to: str
) -> None:
    script, run = tmp_path / "program.py", tmp_path / "tiny-run"
    script.write_text(WAITING, encoding="utf-8")
    with started(script, words) as program:
        assert program.stdout is not None
        assert program.stdout.readline() == "at it\n"
        if to == "all":
            os.killpg(program.pid, signal.SIGINT)
        else:
            program.send_signal(signal.SIGINT)
        try:
            _, said = program.communicate(timeout=120)
        finally:
            program.kill()
    assert program.returncode == 130, said
    assert "Traceback" not in said
    assert said.rstrip().endswith("stopped")
    assert "identify: STOPPED: it was not finished" in said
    assert states(run) == {"import": "made", "identify": "stopped"}
    assert [path.name for path in run.iterdir()] == ["run.json"]
    status, _, message = run_flexura(*words)
    assert status in (0, 1), message
    assert "import: up to date" in message
    assert states(run) == {"import": "made", "identify": "made"}


@pytest.mark.skipif(sys.platform == "win32", reason="sends itself a signal")
def test_the_files_of_a_stage_are_written_all_or_none(words: list[str], tmp_path: Path, run_flexura: Run) -> None:
    script, run = tmp_path / "program.py", tmp_path / "tiny-run"
    script.write_text(SAVING, encoding="utf-8")
    with started(script, words) as program:
        _, said = program.communicate(timeout=300)
    assert program.returncode == 130, said
    assert "Traceback" not in said
    before = {name: (run / name).read_bytes() for name in ("frf.h5", "modes.h5", "modes.csv")}
    assert not list(run.glob("*.part"))
    status, _, message = run_flexura(*words)
    assert status in (0, 1), message
    assert "identify: up to date; made by flexura identify" in message
    assert {name: (run / name).read_bytes() for name in before} == before
