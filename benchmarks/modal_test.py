"""A large modal test from files to modes, and many small files, against the plain ways.

    python benchmarks/modal_test.py [--only frfs|files]

FRFs: 74 points of a hammer, three accelerometers, 1361 lines, 13 modes in the band as an aeroplane model has them
(two pairs close together), coherences that promise too much, and hits that shift each peak by a fifth of its half
width: what made 222 measured FRFs hard. ``flexura identify`` runs as a process of its own; its CPU time and peak
memory are printed. Plain is the same fit to 28 of the FRFs: more FRFs must find no fewer modes.

Files: 500 tables of one FRF each (200 lines), read together and, as an estimate, 20 of them a process each.
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

import numpy as np
from numpy.typing import NDArray

from analysis.estimation.transfer import MeasuredTransfer
from app.files.measurements.guarded import read_columns, read_each
from app.files.uff.frfs import write_frfs

FREQUENCY = np.linspace(2.0, 70.0, 1361)
MODES = np.array([5.6, 15.0, 30.5, 32.9, 33.2, 35.3, 42.1, 45.6, 48.4, 49.3, 52.5, 61.0, 64.8])
"""Hz; two pairs lie one and two bandwidths apart."""
DAMPING = np.array([1.5, 1.0, 1.0, 0.9, 0.9, 1.0, 0.8, 0.7, 0.8, 0.8, 0.9, 0.8, 0.8]) / 100.0
POINTS, ACCELEROMETERS = 74, 3
SHIFT, NOISE = 0.2, 0.01
"""Of a peak's half width from hit to hit; of rms H."""
FILES, ALONE = 500, 20


def _of_children() -> tuple[float, float]:
    """CPU seconds of processes that ended, and the largest memory of one of them, MB."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime, used.ru_maxrss / 1024.0


def frfs() -> list[MeasuredTransfer]:
    """222 accelerances of a structure with 13 modes."""
    rng = np.random.default_rng(0)
    shape = rng.normal(size=(POINTS, len(MODES)))
    s = 2j * np.pi * FREQUENCY[:, None]
    made = []
    for point in range(POINTS):
        own = MODES * (1.0 + SHIFT * DAMPING * rng.normal(size=len(MODES)))  # soft feet, another one at each hit
        w = 2.0 * np.pi * own
        terms = s**2 / (w**2 + 2.0 * DAMPING * w * s + s**2)
        for k in range(ACCELEROMETERS):
            h = terms @ (shape[point] * shape[k])
            noise = rng.normal(size=h.shape) + 1j * rng.normal(size=h.shape)
            h = h + NOISE / np.sqrt(2.0) * np.sqrt(np.mean(np.abs(h) ** 2)) * noise
            made.append(
                MeasuredTransfer(
                    f"p{point + 1}a{k + 1}", f"{k + 1}:+3", f"{100 + point}:+3", "acceleration",
                    FREQUENCY, h, "force", ("m/s2", "N"), coherence=np.full(len(h), 0.998),
                )
            )  # fmt: skip
    return made


def _identified(file: Path, run: Path) -> tuple[int, float, float, float]:
    """Modes of those put in that are found, misfit, CPU seconds, MB."""
    before = _of_children()[0]
    words = [sys.executable, "-m", "flexura", "identify", str(file), "--shared-poles", "--out", str(run), "--json"]
    surroundings = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    done = subprocess.run([*words, "-q"], capture_output=True, text=True, check=False, env=surroundings)
    found = json.loads(done.stdout)
    places: NDArray[np.float64] = np.array([one["frequency_hz"] for one in found["modes"]])
    near = [bool((np.abs(places - f) < zeta * f).any()) for f, zeta in zip(MODES, DAMPING, strict=True)]
    cpu, memory = _of_children()
    return sum(near), float(found.get("misfit", np.nan)), cpu - before, memory


def large_test(folder: Path) -> None:
    """Print modes found, CPU seconds and memory for 28 and for 222 FRFs."""
    made = frfs()
    for chosen in (made[:: len(made) // 28][:28], made):
        file = folder / f"{len(chosen)}.uff"
        write_frfs(file, chosen)
        found, _, cpu, memory = _identified(file, folder / f"run{len(chosen)}")
        print(
            f"{len(chosen)} FRFs x {len(FREQUENCY)} lines: {found} of {len(MODES)} modes, {cpu:.1f} s CPU, "
            f"{memory:.0f} MB"
        )


def many_files(folder: Path) -> None:
    """Print seconds for 500 files read together, and those of a process each."""
    rng = np.random.default_rng(1)
    paths = []
    for number in range(FILES):
        rows = np.column_stack([np.arange(200.0), rng.normal(size=(200, 2))])
        paths.append(folder / f"{number:03d}.csv")
        np.savetxt(paths[-1], rows, "%.8e", ",", header="Frequency [Hz],Re H [m/s/N],Im H [m/s/N]", comments="")
    before, start = _of_children()[0], time.perf_counter()
    own = time.process_time()
    together = list(read_each(paths))
    wall, cpu = time.perf_counter() - start, _of_children()[0] - before + time.process_time() - own
    start = time.perf_counter()
    alone = [read_columns(path) for path in paths[:ALONE]]
    each = (time.perf_counter() - start) * FILES / ALONE
    for one, other in zip(together, alone, strict=False):
        for name, values in other.values.items():
            np.testing.assert_array_equal(one.values[name], values)
    print(f"{FILES} files: {wall:.1f} s, {cpu:.1f} s CPU; a process each {each:.0f} s, ratio {each / wall:.0f}")


if __name__ == "__main__":
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--only", choices=("frfs", "files"))
    only = words.parse_args().only
    with tempfile.TemporaryDirectory() as place:
        if only != "files":
            large_test(Path(place))
        if only != "frfs":
            many_files(Path(place))
