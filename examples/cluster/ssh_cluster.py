"""A Dask cluster on machines that are reached by ssh, for as long as one command of Flexura runs on it.

    python ssh_cluster.py anna,bert:4 run /shared/campaigns --until focus --out /shared/doors

The first word names the machines, each with the number of its workers (default 1). On each of them the same
Flexura must be installed, with the Python of the same path as here, and folders must be seen by the same path:
/shared may be NFS. A cache that all machines share (FLEXURA_CACHE=/shared/cache) spares each of them the building
of models.
"""

import json
import os
import shlex
import socket
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path

MEMORY = "2GB"
"""Of a worker: a campaign takes up to 1.6 GB while the model of a panel is built."""
PATIENCE = 60.0
"""Seconds in which the scheduler is to start."""


def main() -> int:
    """Start the scheduler here and workers there, run the command, end them."""
    machines, words = sys.argv[1].split(","), sys.argv[2:]
    with ExitStack() as stack:
        file = Path(stack.enter_context(tempfile.TemporaryDirectory())) / "scheduler.json"
        _start(
            stack,
            [*_dask("scheduler"), "--host", socket.gethostname(), "--port", "0", "--scheduler-file", str(file)],
        )
        ends = time.monotonic() + PATIENCE
        while not file.exists() or not file.stat().st_size:
            if time.monotonic() > ends:
                sys.exit(f"the scheduler did not start within {PATIENCE:.0f} s")
            time.sleep(0.1)
        address = _address(file)
        cache = os.environ.get("FLEXURA_CACHE")
        for machine in machines:
            host, _, count = machine.partition(":")
            worker = [*_dask("worker"), address, "--nthreads", "1", "--memory-limit", MEMORY]
            worker += ["--nworkers", count or "1", "--no-dashboard"]
            there = shlex.join([*(["env", f"FLEXURA_CACHE={cache}"] if cache else []), *worker])
            _start(stack, ["ssh", "-tt", "-o", "BatchMode=yes", host, there])  # -tt: the workers end with ssh
        command = [sys.executable, "-m", "flexura", *words, "--cluster", address]
        return subprocess.run(command, check=False).returncode  # noqa: S603 (what was typed)


def _dask(part: str) -> list[str]:
    return [sys.executable, "-m", f"distributed.cli.dask_{part}"]


def _address(file: Path) -> str:
    return str(json.loads(file.read_text(encoding="utf-8"))["address"])


def _start(stack: ExitStack, command: list[str]) -> None:
    """Start a process that is ended with the stack."""
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)  # noqa: S603
    stack.callback(process.wait)
    stack.callback(process.terminate)


if __name__ == "__main__":
    sys.exit(main())
