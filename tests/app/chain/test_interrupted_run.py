"""Ctrl-C while ``flexura run`` is at work, as a terminal sends it: finished stages stay whole, status 130."""

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.app.chain.conftest import RunOnce

ROOT = Path(__file__).resolve().parents[3]
Run = Callable[..., tuple[int, str, str]]
PROGRAM = """
import sys, time
from app.main import main
from app.stages import {stage}

def wait(*_, **__):
    print("at it", flush=True)
    time.sleep(600.0)

if __name__ == "__main__":
    {stage}.{function} = wait
    main(sys.argv[1:])
"""
SAVING = """
import os, signal, sys
from app.main import main
from app.stages import update

saved = update.save

def interrupted(*given):
    os.kill(os.getpid(), signal.SIGINT)
    saved(*given)

if __name__ == "__main__":
    update.save = interrupted
    main(sys.argv[1:])
"""


def started(script: Path, words: list[str]) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, str(script), *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        text=True,
        start_new_session=True,
    )


@pytest.mark.skipif(sys.platform == "win32", reason="sends signals to a group of processes")
@pytest.mark.parametrize("to", ["program", "all"])
def test_stages_before_the_one_that_was_stopped_stay(
    fresh: RunOnce, tmp_path: Path, run_flexura: Run, to: str
) -> None:
    script = tmp_path / "program.py"
    script.write_text(PROGRAM.format(stage="update", function="updated_twin"), encoding="utf-8")
    words = [*fresh.words, "--until", "update", "--set", "identify.method=peak-picking"]
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
    assert "update: STOPPED: it was not finished" in said
    assert fresh.states() == {"identify": "made", "update": "stopped"}
    assert {path.name for path in fresh.run.iterdir()} == {"frf.h5", "modes.h5", "modes.csv", "run.json"}
    modes = (fresh.run / "modes.h5").read_bytes()
    status, _, message = run_flexura(*words)
    assert status == 0, message
    assert "identify: up to date" in message
    assert (fresh.run / "modes.h5").read_bytes() == modes
    assert fresh.states() == {"identify": "made", "update": "made"}


@pytest.mark.skipif(sys.platform == "win32", reason="sends itself a signal")
def test_the_files_of_a_stage_are_written_all_or_none(fresh: RunOnce, tmp_path: Path, run_flexura: Run) -> None:
    script = tmp_path / "program.py"
    script.write_text(SAVING, encoding="utf-8")
    words = [*fresh.words, "--until", "update", "--set", "identify.method=peak-picking"]
    with started(script, words) as program:
        _, said = program.communicate(timeout=300)
    assert program.returncode == 130, said
    assert "Traceback" not in said
    before = {name: (fresh.run / name).read_bytes() for name in ("frf.h5", "laws.h5")}
    assert not list(fresh.run.glob("*.part"))
    status, _, message = run_flexura(*words)
    assert status == 0, message
    assert "update: up to date; made by flexura update" in message
    assert {name: (fresh.run / name).read_bytes() for name in before} == before
