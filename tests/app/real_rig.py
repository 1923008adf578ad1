"""A rig served by a process of its own, in real time, and a short campaign on it: of sweeps, or of hits."""

import json
import os
import re
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, Literal

from tests.app.hammer_bench import text_with_oven

ROOT = Path(__file__).resolve().parents[2]
Kind = Literal["sweeps", "hammer"]
SWEEPS = {
    r"^rig = .*": 'rig = "real"',
    r"^max_rate = .*": "max_rate = 60.0\ntimeout = 0.3",
    r"^duration = .*": "duration = 0.5",
    r"^taper = .*": "taper = 0.05",
    r"^tail = .*": "tail = 0.2",
    r"^repeats = .*": "repeats = 2",
    r"^lowest = .*": "lowest = 26.0",
    r"^highest = .*": "highest = 30.0",
    r"^every = .*": "every = 1.0",
    r"^ramp_rate = .*": "ramp_rate = 6.0",
    r"^approach_rate = .*": "approach_rate = 30.0",
    r"^lead = .*": "lead = 1.0",
    r"^soak_before = .*": "soak_before = 2.0",
    r"^poll_interval = .*": "poll_interval = 0.5",
    r"^retries = .*": "retries = 2\ndrift = 1.0",
    r"^\[limits\]": "[programme.settling]\nwithin = 0.5\nlasting = 2.0\n\n[limits]",
}
"""Five sweeps in a minute and a half."""
HITS = {
    r'^rig = "simulated"': 'rig = "real"',
    r"^max_rate = .*": "max_rate = 60.0\ntimeout = 0.3",
    r"^temperatures = .*": "temperatures = [28.0, 30.0]",
    r"^ramp_rate = .*": "ramp_rate = 30.0\npoll_interval = 0.5",
    r"^soak = .*": "soak = 1.0",
    r"^pretrigger = .*": "pretrigger = 0.05",
    r"^duration = .*": "duration = 0.3",
    r"^coupling = \"AC\"": 'coupling = "AC"\niepe_settling = 0.2',
    r"    \[0\.025, 0\.09\].*\n    \[0\.02, 0\.17\].*\n": "",
}
"""Twelve hits at three points and two set-points, in half a minute."""
COUNT: dict[Kind, int] = {"sweeps": 5, "hammer": 12}


def experiment(kind: Kind, at: dict[str, str], other: dict[str, str] | None = None) -> str:
    """Return a short campaign on a served rig, as TOML; `other` replaces further lines, by pattern."""
    text = text_with_oven() if kind == "hammer" else (ROOT / "examples" / "quick-rig.toml").read_text("utf-8")
    wiring = {
        r"^port = .*": f'port = "{at["oven"]}"',
        r"^(thermocouples = .*)": rf'\1\ngrpc = "{at["cards"]}"',
    }
    for pattern, new in ((HITS if kind == "hammer" else SWEEPS) | wiring | (other or {})).items():
        text, count = re.subn(pattern, new, text, count=1, flags=re.MULTILINE)
        if count != 1:
            raise AssertionError(f"{pattern}: not there")
    return text


class RealRig:
    """The rig's process (`tests.app.served_rig`), and an experiment on it.

    Parameters
    ----------
    folder : Path
        Into which the experiment is written.
    kind : str
    """

    def __init__(self, folder: Path, kind: Kind = "sweeps", other: dict[str, str] | None = None) -> None:
        surroundings = {name: value for name, value in os.environ.items() if name != "LD_PRELOAD"}
        self.kind, self.count = kind, COUNT[kind]
        self._child = subprocess.Popen(
            [sys.executable, "-m", "tests.app.served_rig", kind],
            cwd=ROOT,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=surroundings,
        )
        assert self._child.stdout is not None
        self.at: dict[str, str] = json.loads(self._child.stdout.readline())
        self.experiment = folder / "mine.toml"
        self.experiment.write_text(experiment(kind, self.at, other), encoding="utf-8")

    def state(self, word: str = "?") -> dict[str, Any]:
        """Return the rig's true state; ``reset`` begins anew to count for how long the oven is not asked."""
        assert self._child.stdin is not None
        assert self._child.stdout is not None
        self._child.stdin.write(f"{word}\n")
        self._child.stdin.flush()
        return dict(json.loads(self._child.stdout.readline()))

    def at_rest(self, within: float) -> bool:
        """Whether oven and drive are at rest within so many seconds."""
        until = time.monotonic() + within
        while True:
            state = self.state()
            if not state["regulating"] and state["volts"] == 0.0:
                return True
            if time.monotonic() > until:
                return False
            time.sleep(0.1)

    def finished(self, folder: Path) -> dict[str, bytes]:
        """Return the finished sweeps or accepted hits of a campaign."""
        found = {}
        for path in folder.glob("hits/*.h5" if self.kind == "hammer" else "sweeps/*.h5"):
            try:
                found[path.name] = path.read_bytes()
            except FileNotFoundError:  # a partial file that has got its name meanwhile
                continue
        return found

    def end(self) -> None:
        """End the process."""
        with self._child:  # closes its pipes
            self._child.kill()
