"""A window where there is no display: one sentence, exit status 2, and no abort of Qt's."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
NAMES = ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM")


def view(run: Path, *words: str, **named: str) -> "subprocess.CompletedProcess[str]":
    surroundings = {name: value for name, value in os.environ.items() if name not in NAMES} | named
    command = [sys.executable, "-m", "flexura", "view", str(run), *words]
    return subprocess.run(
        command, cwd=ROOT, env=surroundings, capture_output=True, text=True, timeout=120, check=False
    )


@pytest.mark.skipif(sys.platform != "linux", reason="other systems always have a display")
@pytest.mark.parametrize(
    ("named", "why"),
    [
        ({}, "there is no display (neither DISPLAY nor WAYLAND_DISPLAY is set)"),
        ({"DISPLAY": ":4077"}, "the display DISPLAY=:4077 cannot be opened"),
        ({"WAYLAND_DISPLAY": "wayland-4077"}, "the display WAYLAND_DISPLAY=wayland-4077 cannot be opened"),
        ({"QT_QPA_PLATFORM": "xcb"}, "QT_QPA_PLATFORM = xcb cannot be used here"),
        ({"QT_QPA_PLATFORM": "none-such", "DISPLAY": ":0"}, "QT_QPA_PLATFORM = none-such cannot be used here"),
    ],
    ids=["none", "X11", "Wayland", "platform", "unknown platform"],
)
def test_a_display_that_is_not_there_is_told(run: Path, named: dict[str, str], why: str) -> None:
    done = view(run, **named)
    assert done.returncode == 2, done.stderr
    (line,) = done.stderr.strip().splitlines()
    assert line.startswith(f"Error: no window can be opened: {why}")
    assert "--screenshot" in line
    assert "ssh -X" in line


@pytest.mark.slow
def test_pictures_need_none(run: Path, tmp_path: Path) -> None:
    done = view(run, "--screenshot", str(tmp_path / "pictures"))
    assert done.returncode == 0, done.stderr
    assert list((tmp_path / "pictures").glob("view-*.png"))


@pytest.mark.skipif(sys.platform == "win32", reason="signals as POSIX has them")
@pytest.mark.parametrize("number", [2, 15])
def test_a_window_ends_by_a_signal(run: Path, number: int) -> None:
    """No handler of Python's would run in Qt's event loop."""
    code = (
        "import os, sys, threading, signal\n"
        "from PySide6.QtWidgets import QApplication\n"
        "real = QApplication.exec\n"
        "def exec_(*_):\n"
        f"    threading.Timer(1.0, os.kill, (os.getpid(), {number})).start()\n"
        "    return real()\n"
        "QApplication.exec = exec_\n"
        "from app.main import main\n"
        "main(sys.argv[1:])\n"
    )
    surroundings = os.environ | {"QT_QPA_PLATFORM": "offscreen", "PYTHONPATH": str(ROOT)}
    command = ["/bin/sh", "-c", 'trap - INT; exec "$@"', "sh", sys.executable, "-c", code, "view", str(run)]
    done = subprocess.run(command, env=surroundings, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == -number, done.stderr
