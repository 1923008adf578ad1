"""Worker processes of a trial that is killed, or asked to end."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

SCRIPT = """
import os, sys, time
from app.terminal.engine import worker_processes

if __name__ == "__main__":
    with worker_processes(1) as pool:
        print(pool.submit(os.getpid).result(), flush=True)
        pool.submit(time.sleep, 600.0)
        time.sleep(600.0)
"""


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="asks for a process by its number")
def test_workers_end_with_the_process_that_gives_them_work(tmp_path: Path):
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    surroundings = os.environ | {"PYTHONPATH": str(Path(__file__).parents[3])}
    with subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE, env=surroundings) as parent:
        assert parent.stdout is not None
        worker = int(parent.stdout.readline())
        parent.kill()
    for _ in range(600):
        try:
            os.kill(worker, 0)
            if Path(f"/proc/{worker}/stat").read_text().split()[2] == "Z":  # ended, nobody has asked how
                return
        except (ProcessLookupError, FileNotFoundError):
            return
        time.sleep(0.05)
    pytest.fail("the worker goes on without its parent")


TRIAL = """
import os, sys, time
from app.terminal.engine import worker_processes
from app.main import main
import app.blind_trial.trial as trial
import app.commands.blind_trial as verb

def busy() -> None:
    while True:
        time.sleep(0.05)

def run_trial(trial, executor, report, announce) -> None:
    print(*{executor.submit(os.getpid).result() for _ in range(20)}, flush=True)
    for job in [executor.submit(busy) for _ in range(6)]:
        job.result()

if __name__ == "__main__":
    trial.run_trial = run_trial
    main(["blind-trial", "--count", "1", "--seed", "1", "--out", sys.argv[1]])
"""


def _gone(process: int) -> bool:
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except (ProcessLookupError, FileNotFoundError):
        return True


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="asks for a process by its number")
@pytest.mark.parametrize(
    ("to", "number"),
    [
        ("parent", "SIGINT"),
        *(
            pytest.param(*case, marks=pytest.mark.slow)
            for case in (
                ("parent", "SIGTERM"),
                ("worker", "SIGINT"),
                ("worker", "SIGTERM"),
                ("all", "SIGINT"),
                ("all", "SIGTERM"),
                ("all", "SIGHUP"),
            )
        ),
    ],
)
def test_a_signal_to_any_process_ends_all(tmp_path: Path, to: str, number: str):
    """Ctrl-C of a terminal reaches all; a job scheduler asks one. Tasks of minutes are not waited for."""
    script = tmp_path / "script.py"
    script.write_text(TRIAL)
    surroundings = os.environ | {"PYTHONPATH": str(Path(__file__).parents[3])}
    command = [sys.executable, str(script), str(tmp_path / "trial")]
    with subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=surroundings,
        text=True,
        start_new_session=True,
    ) as parent:
        assert parent.stdout is not None
        workers = [int(word) for word in parent.stdout.readline().split()]
        assert workers
        time.sleep(0.5)  # until they are busy
        if to == "all":
            os.killpg(parent.pid, signal.Signals[number])
        else:
            os.kill(parent.pid if to == "parent" else workers[-1], signal.Signals[number])
        try:
            _, said = parent.communicate(timeout=60)
        finally:
            parent.kill()
    assert parent.returncode == 128 + signal.Signals[number], said
    assert said.strip().endswith("stopped")
    assert "Traceback" not in said
    assert all(_gone(worker) for worker in workers)


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc").is_dir(), reason="asks for a process by its number")
def test_a_worker_that_was_killed_is_told(tmp_path: Path):
    """As the system does to the largest process where memory is short."""
    script = tmp_path / "script.py"
    script.write_text(TRIAL)
    surroundings = os.environ | {"PYTHONPATH": str(Path(__file__).parents[3])}
    command = [sys.executable, str(script), str(tmp_path / "trial")]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=surroundings, text=True
    ) as parent:
        assert parent.stdout is not None
        workers = [int(word) for word in parent.stdout.readline().split()]
        os.kill(workers[-1], signal.SIGKILL)
        try:
            _, said = parent.communicate(timeout=60)
        finally:
            parent.kill()
    assert parent.returncode == 2, said
    assert "a worker process was killed, or had too little memory; what is finished stays" in said
    assert "Traceback" not in said
    assert all(_gone(worker) for worker in workers)
