"""`flexura acquire` on a rig in other processes and in real time: what a thread or a simulated error cannot show.

The watchdog is a process, the oven answers on a TCP port, the cards on a gRPC port, and the disk is really full.
"""

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest

from tests.app.real_rig import ROOT, Kind, RealRig
from tests.disk_faults import PREAMBLE, needs_compiler, preloaded

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not sys.platform.startswith("linux"), reason="needs processes and file systems of Linux"),
]

KINDS: tuple[Kind, ...] = ("sweeps", "hammer")


@pytest.fixture(params=KINDS)
def rig(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[RealRig]:
    """Return a rig of a campaign of sweeps, then one of a hammer test."""
    served = RealRig(tmp_path, request.param)
    yield served
    served.end()


@contextmanager
def acquiring(rig: RealRig, folder: Path, **options: Any) -> Iterator["subprocess.Popen[str]"]:
    program = options.pop("program", ["-m", "flexura"])
    command = [sys.executable, *program, "acquire", str(rig.experiment), "--out", str(folder)]
    child = subprocess.Popen(
        command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **options
    )
    with child:
        try:
            yield child
        finally:
            child.kill()


def wait_for(condition: Callable[[], bool], within: float) -> None:
    until = time.monotonic() + within
    while not condition():
        assert time.monotonic() < until, "did not happen in time"
        time.sleep(0.05)


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """Mount a file system of 160 MB."""
    folder = tmp_path / "disk"
    folder.mkdir()
    mounted = subprocess.run(
        [shutil.which("mount") or "mount", "-t", "tmpfs", "-o", "size=160m", "tmpfs", str(folder)], check=False
    )
    if mounted.returncode:
        pytest.skip("a file system can be mounted by root only")
    yield folder
    subprocess.run([shutil.which("umount") or "umount", "-l", str(folder)], check=True)


def fill(folder: Path) -> None:
    """Write until nothing fits any more."""
    with suppress(OSError), (folder / "somebody's film").open("ab") as file:
        while True:
            file.write(bytes(65536))
            file.flush()


@pytest.mark.parametrize("finished", [1, 3])
def test_a_disk_that_is_really_full(rig: RealRig, small_disk: Path, finished: int) -> None:
    folder = small_disk / "campaign"
    with acquiring(rig, folder) as child:
        wait_for(lambda: len(rig.finished(folder)) >= finished, 120.0)
        before = rig.finished(folder)
        fill(small_disk)
        said, _ = child.communicate(timeout=240.0)
    assert child.returncode == 1, said  # no signal
    assert rig.at_rest(1.0), said
    assert "No space left on device" in said
    assert "Traceback" not in said
    assert before.items() <= rig.finished(folder).items()
    (small_disk / "somebody's film").unlink()
    with acquiring(rig, folder) as child:
        said, _ = child.communicate(timeout=240.0)
    assert child.returncode == 0, said
    assert before.items() <= rig.finished(folder).items()
    assert len(rig.finished(folder)) == rig.count


def test_a_memory_that_is_full(rig: RealRig, tmp_path: Path) -> None:
    folder = tmp_path / "campaign"
    with acquiring(rig, folder) as child:
        wait_for(lambda: len(rig.finished(folder)) >= 1, 120.0)
        before = rig.finished(folder)
        used = int(Path(f"/proc/{child.pid}/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
        subprocess.run(
            [shutil.which("prlimit") or "prlimit", "--pid", str(child.pid), f"--as={used + 1_000_000}"], check=True
        )
        child.wait(240.0)
    assert rig.at_rest(30.0)
    assert before.items() <= rig.finished(folder).items()


def _busy(rig: RealRig) -> bool:
    """Whether a voltage is being played; nothing is in a hammer test, which waits for the next hit."""
    return rig.kind == "hammer" or rig.state()["volts"] != 0.0


def _taken_up_again(rig: RealRig, folder: Path) -> tuple[int, str]:
    """Run a campaign again, as soon as the watchdog of the one before has seen the oven cool and lets it go."""
    until = time.monotonic() + 120.0
    while True:
        with acquiring(rig, folder) as child:
            said, _ = child.communicate(timeout=240.0)
        if "is in use by process" not in said or time.monotonic() > until:
            return child.returncode, said
        time.sleep(3.0)


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSEGV, signal.SIGQUIT])
def test_killed_in_a_sweep_the_drive_comes_to_rest_too(rig: RealRig, tmp_path: Path, number: int) -> None:
    folder = tmp_path / "campaign"
    text = rig.experiment.read_text(encoding="utf-8")
    # on a busy computer a second passes between two looks at the output, and sweeps of half a second were not seen
    rig.experiment.write_text(text.replace("duration = 0.5", "duration = 1.0"), encoding="utf-8")
    with acquiring(rig, folder) as child:
        wait_for(lambda: _busy(rig) and bool(rig.finished(folder)), 120.0)
        before = rig.finished(folder)
        child.send_signal(number)
        child.wait(240.0)
    assert rig.at_rest(60.0)
    if number != signal.SIGQUIT:  # the watchdog took over, and holds the rig until it has said this
        log = folder / "watchdog.log"
        wait_for(lambda: log.exists() and "the oven is at rest" in log.read_text(), 120.0)
        assert "NOT AT REST" not in log.read_text()
    status, said = _taken_up_again(rig, folder)
    # a set-point of a sweep may have passed meanwhile, and is given up
    assert status in ((0, 1) if rig.kind == "sweeps" else (0,)), said
    assert "is in use by process" not in said
    assert before.items() <= rig.finished(folder).items()


def test_a_second_campaign_does_not_move_the_oven_meanwhile(rig: RealRig, tmp_path: Path) -> None:
    other = rig.experiment.with_name("other.toml")
    text = rig.experiment.read_text(encoding="utf-8")
    other.write_text(text.replace("socket://127.0.0.1", "socket://localhost"), encoding="utf-8")
    with acquiring(rig, tmp_path / "campaign") as child:
        wait_for(lambda: bool(rig.state()["regulating"]), 60.0)
        command = [sys.executable, "-m", "flexura", "safe", str(other)]
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
        assert done.returncode == 3
        assert f"in use by process {child.pid}" in done.stdout + done.stderr
        assert rig.state()["regulating"]
        child.send_signal(signal.SIGINT)
        child.communicate(timeout=120.0)
    assert child.returncode == 130
    assert rig.at_rest(1.0)


HUNG_CALLS = tuple(int(one) for one in os.environ.get("HUNG_CALLS", "12 40 90").split())
"""Which of the calls to the disk hang, counted from the start of the campaign."""


@needs_compiler
@pytest.mark.parametrize("number", HUNG_CALLS)
def test_a_call_to_the_disk_that_hangs_for_ever(rig: RealRig, tmp_path: Path, number: int) -> None:
    """Every call from one on: as of a network share that has gone."""
    folder = tmp_path / "campaign"
    code = f"{PREAMBLE}\nfrom app.main import flexura\narm({str(folder)!r}, {number}, -1)\nflexura(sys.argv[1:])"
    with acquiring(rig, folder, program=["-c", code], env=preloaded(tmp_path)) as child:
        until = time.monotonic() + 60.0
        while not rig.state()["regulating"]:
            if time.monotonic() > until:  # one of the first calls: the oven has never been asked for anything
                return
            time.sleep(0.1)
        before = rig.finished(folder)
        rig.state("reset")
        wait_for(lambda: not rig.state()["regulating"], 240.0)
        assert rig.state()["longest"] < 10.0  # asked all the time
        assert child.poll() is None  # it hangs still
        assert rig.at_rest(60.0)
        log = folder / "watchdog.log"
        wait_for(lambda: log.exists() and "stood still" in log.read_text(), 60.0)
    assert before.items() <= rig.finished(folder).items()
