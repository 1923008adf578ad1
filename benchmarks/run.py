"""``flexura run`` against the six verbs typed one after the other: seconds, processor time, peak memory.

    python benchmarks/run.py [RECORDED_CAMPAIGN] [--gap]

Both ways begin with a recorded campaign and end with the report, once with an empty cache of models and once with
the models in it; the run is then repeated with nothing to do. Laws, filters and networks of both ways must agree.
On a busy machine compare processor time: seconds tell how busy it was.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from app.files.results.laws_file import load_laws
from app.files.results.panel_files import load_compensation, load_focusing

ROOT = Path(__file__).resolve().parents[1]


@dataclass(frozen=True)
class Cost:
    """Seconds by the clock, seconds of processors, and bytes of the largest process."""

    seconds: float
    processor_seconds: float
    peak_bytes: int


def cost(commands: Sequence[Sequence[str]], cache: Path) -> Cost:
    """Run commands one after the other; an exit status of 1, not good enough, is no fault here."""
    before, started = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    for words in commands:
        done = subprocess.run(
            [sys.executable, "-m", "flexura", *words, "--quiet"],
            env={**os.environ, "FLEXURA_CACHE": str(cache)},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
        if done.returncode not in (0, 1):
            raise RuntimeError(f"flexura {' '.join(words)}: {done.stderr}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return Cost(time.perf_counter() - started, spent, after.ru_maxrss * 1024)


def verbs(recording: Path, folder: Path, *, gap: bool) -> list[list[str]]:
    """Return the commands of the plain way."""
    campaign, run = str(folder / "campaign"), str(folder / "run")
    plate = [[verb, campaign, "--out", run] for verb in ("identify", "update", *(("gap",) if gap else ()))]
    return [
        ["import", str(recording), "--out", campaign],
        *plate,
        ["focus", run],
        ["compensate", run],
        ["report", run],
    ]


def same(ours: Path, theirs: Path) -> None:
    """Fail where two run folders hold other numbers."""
    laws, others = (load_laws(run / "laws.h5") for run in (ours, theirs))
    np.testing.assert_allclose(laws.coefficients, others.coefficients, rtol=1e-9)
    filters, beside = (load_focusing(run / "filters.h5")[1] for run in (ours, theirs))
    scale = np.abs(filters.bank.taps).max()
    np.testing.assert_allclose(filters.bank.taps, beside.bank.taps, rtol=1e-6, atol=1e-9 * scale)
    found, known = (load_compensation(run / "compensation.h5")[1] for run in (ours, theirs))
    np.testing.assert_allclose(found.largest_loss, known.largest_loss, rtol=1e-2, atol=1e-6)


def main() -> None:
    """Run both ways, print, write JSON."""
    words = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    words.add_argument("campaign", nargs="?", type=Path, default=ROOT / "examples" / "pp-plate")
    words.add_argument("--gap", action="store_true", help="with the search for effects")
    given = words.parse_args()
    recording, without = given.campaign, [] if given.gap else ["--without", "gap"]
    found: dict[str, Cost] = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for state in ("cold", "warm"):
            one, six = folder / state / "one", folder / state / "six"
            found[f"run {state}"] = cost(
                [["run", str(recording), "--out", str(one / "run"), *without]], folder / "models-of-run"
            )
            found[f"verbs {state}"] = cost(verbs(recording, six, gap=given.gap), folder / "models-of-verbs")
            same(one / "run", six / "run")
        again = ["run", str(recording), "--out", str(folder / "warm" / "one" / "run"), *without]
        found["nothing to do"] = cost([again], folder / "models-of-run")
    for what, spent in found.items():
        print(
            f"{what:<14} {spent.seconds:7.1f} s, {spent.processor_seconds:7.1f} s of processors, "
            f"largest process so far {spent.peak_bytes / 1e9:.2f} GB"
        )
    ratios = {state: found[f"verbs {state}"].seconds / found[f"run {state}"].seconds for state in ("cold", "warm")}
    print(f"the verbs take {ratios['cold']:.2f} times as long cold, {ratios['warm']:.2f} times warm")
    results = ROOT / "benchmarks" / "results"
    results.mkdir(exist_ok=True)
    result = {"costs": {what: asdict(spent) for what, spent in found.items()}, "ratios": ratios, "gap": given.gap}
    (results / "run.json").write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
