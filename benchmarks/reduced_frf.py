"""Reduced against direct evaluation of the recorded campaign's transfer, on the same plate, material and lines.

The plain way factorizes the full complex dynamic stiffness at every line; it is done on a few lines of the
band and stated per line. The reduced way evaluates every line and its three derivatives are timed as well.
Building the basis, once per plate, is timed beside them.

    python benchmarks/reduced_frf.py
"""

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from analysis.experiment import Patch, Plate
from analysis.material import LocalLaws, MaterialBox
from simulation.reduction.vectors.reduce import reduce
from simulation.shell.assembly import assemble_for
from simulation.shell.electric_load import ElectricLoad
from simulation.twin.declared_plate import DeclaredPlate
from simulation.twin.instruments import Instruments
from simulation.twin.twin import Twin

PLATE = Plate(length_x=0.24, length_y=0.19, thickness=0.003, mass=0.12996)
PATCHES = [
    Patch(id="A1", role="actuator", center=(0.2, 0.155), size=(0.02, 0.02), thickness=0.0005),
    Patch(id="S1", role="sensor", center=(0.04, 0.035), size=(0.02, 0.02), thickness=0.0005),
]
BOX, BAND = MaterialBox((0.8e9, 4e9), (0.30, 0.48), (0.02, 0.12)), (100.0, 1500.0)
MATERIAL = (2.26e9, 0.37, 0.082)
LOAD = ElectricLoad(305e3, 120e-12)
LINES = np.arange(240, 3601) / 2.4  # the lines of a 2.4 s record inside the band
FULL_LINES = LINES[:: LINES.size // 12]
RESULT = Path(__file__).parent / "results" / "reduced_frf.json"


def seconds(work: Callable[[], object], repeats: int) -> float:
    """Shortest time of several runs."""
    best = float("inf")
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - start)
    return best


def measure() -> dict[str, float | int]:
    """Time both ways and compare their answers."""
    start = time.perf_counter()
    model = assemble_for(PLATE, PATCHES, BOX, BAND)
    assembly = time.perf_counter() - start
    start = time.perf_counter()
    reduced = reduce(model, BOX, BAND)[0]
    basis = time.perf_counter() - start
    twin = Twin(DeclaredPlate(reduced), Instruments.of_patches(0, (1,), LOAD))

    start = time.perf_counter()
    full = model.frf(*MATERIAL, FULL_LINES, actuator=0, sensors=(1,), load=LOAD)
    per_full_line = (time.perf_counter() - start) / FULL_LINES.size
    frf = seconds(lambda: twin.frf(LocalLaws.of_material(*MATERIAL), LINES), 10)
    sensitivities = seconds(lambda: twin.linearise(LocalLaws.of_material(*MATERIAL), LINES), 10)

    answer = twin.frf(LocalLaws.of_material(*MATERIAL), LINES)
    rms = float(np.sqrt(np.mean(np.abs(answer) ** 2)))
    difference = float(np.abs(twin.frf(LocalLaws.of_material(*MATERIAL), FULL_LINES) - full).max()) / rms
    return {
        "unknowns": model.size,
        "coordinates": reduced.size,
        "lines": LINES.size,
        "assembly_s": assembly,
        "basis_s": basis,
        "full_s_per_line": per_full_line,
        "full_s_all_lines": per_full_line * LINES.size,
        "reduced_s_all_lines": frf,
        "reduced_with_three_derivatives_s": sensitivities,
        "ratio": per_full_line * LINES.size / frf,
        "difference_over_rms": difference,
        "stated_error": reduced.error,
    }


def main() -> int:
    """Print and store the figures; status 1 if the answers differ by more than the error stated."""
    with threadpool_limits(1):
        figures = measure()
    RESULT.parent.mkdir(exist_ok=True)
    RESULT.write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")
    for name, value in figures.items():
        print(f"{name:34} {value:.6g}")
    same = figures["difference_over_rms"] <= figures["stated_error"]
    print(f"reduced is {figures['ratio']:.0f} times faster, {'same' if same else 'ANOTHER'} result; {RESULT}")
    return 0 if same and figures["ratio"] >= 1000.0 else 1


if __name__ == "__main__":
    sys.exit(main())
