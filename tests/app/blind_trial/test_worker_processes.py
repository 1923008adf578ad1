"""Worker processes of a trial that is killed."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

SCRIPT = """
import os, sys, time
from app.blind_trial.trial import worker_processes

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
