"""Campaigns per hour of a fleet: one worker process, two, and two workers of Dask; the cost of an empty task.

    python benchmarks/cluster.py [--campaigns 8] [--until update]

Simulated panels are recorded first, and run once so that their model is in the cache; each way then makes the
stages of all anew. The results of all ways must be the same. Efficiency is the processor time of one process over
that of the way: on a busy machine seconds tell how busy it was, and processor time what the way itself costs. For
two idle processors, efficiency by the clock is printed beside it.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, as_completed
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from distributed import LocalCluster

from app.files.results.laws_file import load_updated
from app.terminal.cluster import cluster_workers
from app.terminal.engine import worker_processes

ROOT = Path(__file__).resolve().parents[1]
EMPTY_TASKS = 200
MEMORY = 1.0e9
SAME = 1e-9
"""Relative difference of E between the ways: they run the same code."""


def flexura(*words: object, cache: Path) -> tuple[float, float]:
    """Type a command; seconds by the clock and of processors, of all its processes."""
    before, started = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-m", "flexura", *map(str, words), "--quiet"],
        env=os.environ | {"FLEXURA_CACHE": str(cache)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        check=False,
    )
    if done.returncode not in (0, 1):
        raise RuntimeError(f"flexura {words}: {done.stderr}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return time.perf_counter() - started, spent


@contextmanager
def local_cluster(cache: Path, memory: str = "2GB") -> Iterator[LocalCluster]:
    """Two workers with the cache."""
    os.environ["FLEXURA_CACHE"] = str(cache)
    with LocalCluster(n_workers=2, threads_per_worker=1, memory_limit=memory, dashboard_address=":0") as made:
        yield made


def moduli(folder: Path) -> np.ndarray:
    """E of all sweeps of all campaigns, Pa."""
    return np.concatenate(
        [load_updated(one)[0].material.youngs_modulus for one in sorted(folder.glob("*/laws.h5"))]
    )


def per_task(executor: AbstractContextManager[Executor]) -> float:
    """Seconds of an empty task, when the workers are there."""
    with executor as pool:
        for one in as_completed([pool.submit(os.getpid) for _ in range(4)]):
            one.result()
        started = time.perf_counter()
        for one in as_completed([pool.submit(os.getpid) for _ in range(EMPTY_TASKS)]):
            one.result()
        return (time.perf_counter() - started) / EMPTY_TASKS


def main() -> None:
    """Measure, compare and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--campaigns", type=int, default=8)
    parser.add_argument("--until", default="update")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        cache, panels = folder / "cache", folder / "panels"
        text = (ROOT / "examples/quick-rig.toml").read_text(encoding="utf-8")
        panels.mkdir()
        for k in range(asked.campaigns):
            file = folder / f"panel-{k}.toml"
            file.write_text(text.replace("seed = 1", f"seed = {k + 1}"), encoding="utf-8")
            flexura("acquire", file, "--out", panels / file.stem, cache=cache)
        words = ("run", panels, "--until", asked.until, "--without", "gap")
        flexura(*words, "--out", folder / "first", cache=cache)
        found: dict[str, tuple[float, float]] = {}
        found["1 process"] = flexura(*words, "--out", folder / "one", "--workers", 1, cache=cache)
        found["2 processes"] = flexura(*words, "--out", folder / "two", "--workers", 2, cache=cache)
        with local_cluster(cache) as cluster:
            spent = _of_workers(cluster)
            address = cluster.scheduler_address
            clock, ours = flexura(*words, "--out", folder / "dask", "--cluster", address, cache=cache)
            found["2 of Dask"] = (clock, ours + _of_workers(cluster) - spent)
            overhead = {"2 of Dask": per_task(cluster_workers(address, folder, MEMORY, lambda *_: None))}
        overhead["2 processes"] = per_task(worker_processes(2))
        known = moduli(folder / "one")
        for other in ("two", "dask"):
            np.testing.assert_allclose(moduli(folder / other), known, rtol=SAME)
        print(json.dumps(_record(found, overhead, asked.campaigns), indent=1))


def _of_workers(cluster: LocalCluster) -> float:
    """Seconds of processors that the workers of a cluster have spent."""
    from distributed import Client

    read: Callable[[], Any] = time.process_time
    with Client(cluster.scheduler_address, set_as_default=False) as client:
        return float(sum(client.run(read).values()))


def _record(found: dict[str, tuple[float, float]], overhead: dict[str, float], count: int) -> dict[str, Any]:
    clock, spent = found["1 process"]
    return {
        name: {
            "campaigns_per_hour": round(3600.0 * count / seconds, 1),
            "seconds": round(seconds, 1),
            "processor_seconds": round(processors, 1),
            "efficiency_by_processor_time": round(spent / processors, 3),
            "efficiency_by_the_clock": round(clock / (seconds * (1 if name.startswith("1") else 2)), 3),
            "milliseconds_of_an_empty_task": round(1e3 * overhead[name], 2) if name in overhead else None,
        }
        for name, (seconds, processors) in found.items()
    }


if __name__ == "__main__":
    main()
