"""Whether a window can be opened at all: Qt ends the process by SIGABRT where it cannot."""

import os
import subprocess
import sys

DRAWS_INTO_MEMORY = ("offscreen", "minimal")
PATIENCE = 30.0
"""Seconds: a desktop answers within one, one at the other end of a slow network in a few."""
TRIAL = "from PySide6.QtGui import QGuiApplication; QGuiApplication(['flexura'])"
ONWARD = (
    "--screenshot DIR writes every page as a picture and needs no display; to see the window, log in with ssh -X "
    "(X forwarding), or call flexura view on a computer with a desktop"
)


def display_fault() -> str | None:
    """Return why no window can be opened, and what to do; None where one can.

    A display that is named may be gone, or refuse this user, and a part of Qt's own may be missing: it is opened
    in a process of its own first. Windows and macOS always have one.
    """
    chosen = os.environ.get("QT_QPA_PLATFORM", "").partition(":")[0]
    if chosen in DRAWS_INTO_MEMORY or (not chosen and sys.platform in ("win32", "darwin")):
        return None
    try:
        tried = subprocess.run(  # noqa: S603 (words of ours)
            [sys.executable, "-P", "-c", TRIAL],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            timeout=PATIENCE,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return f"no window can be opened: {_named()} does not answer within {PATIENCE:.0f} s; {ONWARD}"
    return None if tried.returncode == 0 else f"no window can be opened: {_unusable(chosen)}; {ONWARD}"


def _unusable(chosen: str) -> str:
    if chosen:
        return f"QT_QPA_PLATFORM = {chosen} cannot be used here"
    if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        return "there is no display (neither DISPLAY nor WAYLAND_DISPLAY is set)"
    return f"{_named()} cannot be opened (if it is there: apt install libxcb-cursor0, which Qt needs)"


def _named() -> str:
    names = [f"{name}={os.environ[name]}" for name in ("DISPLAY", "WAYLAND_DISPLAY") if os.environ.get(name)]
    return f"the display {' '.join(names)}" if names else "the display"
