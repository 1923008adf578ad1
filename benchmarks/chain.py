"""The whole chain, folder to report: seconds and peak memory, cold and with the twin's basis cached.

    python benchmarks/chain.py [RECORDED_CAMPAIGN]

Every verb runs as its own process, as a user would type it. The plain way here is the cold one: the twin's
basis is computed; the second run finds it in the cache. Both must print the same estimates.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def run(campaign: Path, folder: Path, cache: Path) -> tuple[dict[str, float], list[dict[str, float]]]:
    """Seconds of every verb, and the estimates that update printed."""
    verbs = [
        ["import", str(campaign), "--out", str(folder / "campaign")],
        ["identify", str(folder / "campaign"), "--out", str(folder / "run")],
        ["update", str(folder / "campaign"), "--out", str(folder / "run"), "--json"],
        ["focus", str(folder / "run")],
        ["compensate", str(folder / "run")],
        ["study", "all", str(folder / "run")],
        ["report", str(folder / "run")],
    ]
    seconds, estimates = {}, []
    for words in verbs:
        started = time.perf_counter()
        environment = {**os.environ, "FLEXURA_CACHE": str(cache)}
        done = subprocess.run(
            [sys.executable, "-m", "flexura", *words],
            env=environment,
            stdout=subprocess.PIPE,
            text=True,
            check=True,
        )
        seconds[words[0]] = time.perf_counter() - started
        if "--json" in words:
            estimates = json.loads(done.stdout)["temperatures"]
    return seconds, estimates


def main() -> None:
    """Run twice, print, write JSON; fail where the two disagree."""
    words = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    words.add_argument("campaign", nargs="?", type=Path, default=ROOT / "examples" / "pp-plate")
    campaign = words.parse_args().campaign
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        cold, first = run(campaign, folder / "cold", folder / "cache")
        warm, second = run(campaign, folder / "warm", folder / "cache")
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024
    for verb in cold:
        print(f"{verb:<12} {cold[verb]:7.2f} s cold {warm[verb]:7.2f} s with the basis cached")
    result = {
        "cold_seconds": sum(cold.values()),
        "warm_seconds": sum(warm.values()),
        "ratio": sum(cold.values()) / sum(warm.values()),
        "peak_bytes": peak,
        "verbs": {verb: {"cold": cold[verb], "warm": warm[verb]} for verb in cold},
    }
    print(
        f"total {result['cold_seconds']:.1f} s cold, {result['warm_seconds']:.1f} s warm, "
        f"ratio {result['ratio']:.2f}; largest process {peak / 1e9:.2f} GB"
    )
    results = ROOT / "benchmarks" / "results"
    results.mkdir(exist_ok=True)
    (results / "chain.json").write_text(json.dumps(result, indent=1) + "\n")
    assert first == second, "the cached basis gives other estimates"  # noqa: S101


if __name__ == "__main__":
    main()
