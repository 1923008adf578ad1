"""Campaigns in real time whose disk fails or hangs at one call after the other, by the hundred.

    python -m tests.app.fault_runs full --count 400     every call from one on: disk full, or an I/O error
    python -m tests.app.fault_runs hang --count 200     every call from one on waits for ever
    python -m tests.app.fault_runs hang --rig hammer --count 100

Cards on a gRPC port, the oven on a TCP port, both in a process that outlives the campaign; the campaign with its
watchdog is what `flexura acquire` runs, forked from a process that has imported it already. It counts, for `full`:
campaigns that ended by a signal, left the oven on, lost or altered a finished file, or printed a traceback; for
`hang`: those whose oven was not asked for longer than `ASKED_EVERY`, was not at rest within a minute after the
watchdog took over, was silent about it, or lost a finished file. A run whose call never came is ``not reached``.
"""

import argparse
import errno
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any

from tests.app.real_rig import Kind, RealRig
from tests.disk_faults import preloaded

ASKED_EVERY = 10.0
"""s."""
ERRORS = (errno.ENOSPC, errno.EIO, errno.EROFS, errno.EDQUOT)
OTHER = {
    "sweeps": {
        r"^every = .*": "every = 2.0",
        r"^ramp_rate = .*": "ramp_rate = 15.0",
        r"^soak_before = .*": "soak_before = 1.0",
        r"^tolerance = .*": "tolerance = 0.7",
        r"^drift = .*": "drift = 2.0\nlost_after = 60.0",
    },
    "hammer": {r"^hottest = .*": "hottest = 70.0\nlost_after = 60.0"},
}
"""Three sweeps within a minute."""


def last_event(folder: Path) -> str:
    """Return what was logged last: the phase of the campaign."""
    try:
        line = (folder / "events.jsonl").read_text("utf-8").splitlines()[-1]
        event = json.loads(line)
        return str(event.get("command", event["event"]))
    except (OSError, IndexError, ValueError):
        return "before the first event"


def campaign(file: Path, folder: Path, said: Path, number: int, error: int) -> int:
    """Fork, let the disk fail from a call on, run the campaign; return the child's id."""
    child = os.fork()
    if child:
        return child
    import ctypes

    status = 70
    try:
        os.setsid()
        out = os.open(said, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(out, 1)
        os.dup2(out, 2)
        disk = ctypes.CDLL(os.environ["LD_PRELOAD"])
        disk.arm(os.fsencode(f"{folder}/"), ctypes.c_long(number), error)
        from app.main import main

        try:
            main(["acquire", str(file), "--out", str(folder)])
            status = 0
        except SystemExit as ended:
            status = ended.code if isinstance(ended.code, int) else 1
        disk.counted.restype = ctypes.c_long
        os.write(2, f"\ncalls: {disk.counted()}\n".encode())
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


def told(folder: Path, said: Path) -> bool:
    """Whether the watchdog or the campaign itself has said that it stands still."""
    files = [one for one in (folder / "watchdog.log", said) if one.exists()]
    return any("stood still" in one.read_text("utf-8", "replace") for one in files)


def run(rig: RealRig, place: Path, number: int, error: int) -> dict[str, Any]:
    """Run one campaign with its fault, and return what came of it."""
    folder, said = place / f"campaign-{number}", place / f"said-{number}"
    shutil.rmtree(folder, ignore_errors=True)
    child = campaign(rig.experiment, folder, said, number, error)
    before, status, worst = {}, None, 0.0
    rig.state("reset")
    began, stood, phase = time.monotonic(), None, ""
    hot = False
    while time.monotonic() - began < 400.0:
        ended, raw = os.waitpid(child, os.WNOHANG)
        now = rig.finished(folder)
        lost = [name for name, content in before.items() if now.get(name) != content]
        if lost:
            break
        before = now
        state = rig.state()
        if state["regulating"] and not hot:  # until then nobody had to ask it
            hot, state = True, rig.state("reset")
        worst = max(worst, state["longest"]) if state["regulating"] else worst
        if ended:
            status = raw
            break
        if error == -1 and hot and not state["regulating"]:
            time.sleep(3.0)  # a campaign whose call never came ends by itself
            ended, status = os.waitpid(child, os.WNOHANG)
            status, stood = (status, None) if ended else (None, time.monotonic() - began)
            break
        time.sleep(0.2)
    phase = last_event(folder)
    rested = rig.at_rest(60.0)
    until = time.monotonic() + 60.0
    while error == -1 and stood is not None and time.monotonic() < until:
        if told(folder, said):
            break
        time.sleep(0.2)
    if status is None:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
    now = rig.finished(folder)
    text = said.read_text("utf-8", "replace")
    return {
        "call": number,
        "error": error,
        "phase": phase,
        "signal": os.WTERMSIG(status) if status is not None and os.WIFSIGNALED(status) else 0,
        "exit": os.WEXITSTATUS(status) if status is not None and os.WIFEXITED(status) else None,
        "rested": rested,
        "hot": hot,
        "silence": round(worst, 2),
        "kept": len(now),
        "lost": [name for name, content in before.items() if now.get(name) != content],
        "traceback": "Traceback" in text,
        "told": told(folder, said),
        "stood": stood,
        "said": text[-400:],
    }


def verdict(result: dict[str, Any]) -> str:
    """Return ``good``, ``not reached``, or what is wrong."""
    if result["signal"]:
        return f"ended by signal {result['signal']}"
    if not result["rested"]:
        return "not at rest"
    if result["lost"]:
        return "a finished file was lost"
    if result["traceback"]:
        return "traceback"
    if result["exit"] == 0:
        return "not reached"
    if result["error"] == -1 and result["hot"]:
        if result["silence"] >= ASKED_EVERY:
            return f"the oven was not asked for {result['silence']:.0f} s"
        if not result["told"] and result["exit"] is None:
            return "nothing said"
    return "good"


def work(kind: Kind, words: list[tuple[int, int]]) -> None:
    """Run the campaigns of one worker; a line of JSON for each."""
    import drivers.ni.cards
    import drivers.ni.daqmx  # noqa: F401

    with tempfile.TemporaryDirectory(prefix="fault-runs-") as name:
        place = Path(name)
        rig = RealRig(place, kind, OTHER[kind])
        for number, error in words:
            try:
                result = run(rig, place, number, error)
                while "is in use by process" in result["said"]:  # not begun: the watchdog of the run before
                    time.sleep(3.0)
                    result = run(rig, place, number, error)
            except (OSError, ValueError) as failed:
                result = {"call": number, "error": error, "failed": repr(failed)}
            sys.stdout.write(f"{json.dumps(result)}\n")
            sys.stdout.flush()
        time.sleep(70.0)  # the last watchdog, until it has seen the oven at rest
        rig.end()


def main() -> None:
    """Share the runs among workers, and print a table."""
    words = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    words.add_argument("fault", choices=["full", "hang", "none"])
    words.add_argument("--rig", choices=["sweeps", "hammer"], default="sweeps")
    words.add_argument("--count", type=int, default=20)
    words.add_argument("--calls", type=int, default=220, help="of an undisturbed campaign")
    words.add_argument("--jobs", type=int, default=4)
    words.add_argument("--seed", type=int, default=0)
    words.add_argument("--work", help=argparse.SUPPRESS)
    words.add_argument("--out", type=Path, default=Path("fault-runs.jsonl"))
    asked = words.parse_args()
    if asked.work:
        work(asked.rig, [tuple(one) for one in json.loads(asked.work)])
        return
    rng = random.Random(asked.seed)  # noqa: S311 (moments, not secrets)
    spread = [1 + (asked.calls * place) // asked.count for place in range(asked.count)]
    error = {"hang": lambda n: -1, "full": lambda n: ERRORS[n % len(ERRORS)], "none": lambda n: 0}[asked.fault]
    runs = [(call if asked.fault != "none" else 0, error(place)) for place, call in enumerate(spread)]
    rng.shuffle(runs)
    tally: Counter[str] = Counter()
    phases: Counter[str] = Counter()
    with tempfile.TemporaryDirectory(prefix="preloaded-") as name, asked.out.open("w", encoding="utf-8") as kept:
        surroundings = preloaded(Path(name))
        workers = []
        for job in range(asked.jobs):
            mine = runs[job :: asked.jobs]
            command = [sys.executable, "-m", "tests.app.fault_runs", asked.fault, "--rig", asked.rig]
            log = (Path(name) / f"worker-{job}").open("w+b")
            process = subprocess.Popen(
                [*command, "--work", json.dumps(mine)],
                cwd=Path(__file__).resolve().parents[2],
                env=surroundings,
                stdout=log,
                start_new_session=True,
            )
            workers.append((process, log, Path(log.name), [0]))
        while True:
            alive = any(process.poll() is None for process, *_ in workers)
            for _, _, path, place in workers:
                lines = path.read_text("utf-8").splitlines(keepends=True)
                for line in lines[place[0] :]:
                    if not line.endswith("\n"):
                        break
                    place[0] += 1
                    result = json.loads(line)
                    kept.write(line)
                    kept.flush()
                    found = f"worker: {result['failed']}" if "failed" in result else verdict(result)
                    tally[found] += 1
                    phases[result.get("phase", "")] += 1
                    if found not in ("good", "not reached"):
                        sys.stderr.write(f"{found}: {line}")
            if not alive:
                break
            time.sleep(1.0)
    told = f"{asked.fault}, {asked.rig}: {tally.total()} runs: {dict(tally)}; last event: {dict(phases)}"
    sys.stdout.write(f"{told}\n")


if __name__ == "__main__":
    main()
