"""Cost of a plate's first models, and what they are worth: for updating, for a panel, with effects.

The plain way factorizes the full complex dynamic stiffness at every line; it is done on a few lines and stated for
all. Both ways have to agree within the error that is certified. Memory is the largest resident set so far.

    python benchmarks/twin.py             the plates without effects, under a minute
    python benchmarks/twin.py --effects   with the plate with effects, half a minute more
"""

import json
import resource
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from analysis.experiment import Acquisition, Attachment, Experiment, OvenDeclaration, Patch, Plate, Protocol
from analysis.material import LocalLaws, MaterialBox
from simulation.reduction.basis_key import BasisTraining
from simulation.reduction.effect_reduction import reduce_with_effects
from simulation.reduction.vectors.reduce import reduce
from simulation.shell.assembly import assemble_for
from simulation.shell.electric_load import ElectricLoad
from simulation.shell.fineness import Fineness
from simulation.twin.declared_plate import DeclaredPlate
from simulation.twin.instruments import Instruments
from simulation.twin.twin import Twin

BOX = MaterialBox((0.8e9, 4.0e9), (0.30, 0.49), (0.005, 0.15))
MATERIAL = (2.26e9, 0.37, 0.082)
LOAD = ElectricLoad(305e3, 120e-12)
BAND = (100.0, 1500.0)
LINES = np.linspace(*BAND, 2161)
RESULT = Path(__file__).parent / "results" / "twin.json"


def patch(name: str, role: str, center: tuple[float, float], **shape: Any) -> Patch:
    """Return a patch 0.5 mm thick, 20 mm square unless `shape` says otherwise."""
    extent = shape if "diameter" in shape else {"size": (0.02, 0.02), **shape}
    return Patch.model_validate({"id": name, "role": role, "center": center, "thickness": 5e-4, **extent})


PAPER = Plate(length_x=0.24, length_y=0.19, thickness=0.003, mass=0.12996)
PAIR = (patch("A1", "actuator", (0.2, 0.155)), patch("S1", "sensor", (0.04, 0.035)))
SIX = tuple(
    patch(f"A{k}", "actuator", place)
    for k, place in enumerate([(0.03, 0.03), (0.12, 0.03), (0.21, 0.03), (0.03, 0.16), (0.12, 0.16), (0.21, 0.16)])
)
TRIM = Plate.model_validate(
    {
        "outline": {"kind": "polygon", "points": [(0.0, 0.0), (0.4, 0.0), (0.4, 0.2), (0.3, 0.3), (0.0, 0.25)]},
        "hole": [{"kind": "ellipse", "center": (0.12, 0.12), "radii": (0.05, 0.03), "angle": 23.0}],
        "thickness": 0.003,
        "mass": 0.2935,
    }
)
TRIM_PATCHES = (
    patch("A1", "actuator", (0.3, 0.1), size=(0.03, 0.02), angle=28.0),
    patch("S1", "sensor", (0.25, 0.22), diameter=0.025),
    patch("S2", "sensor", (0.03, 0.2)),
)


def seconds(work: Callable[[], object], repeats: int) -> float:
    """Shortest time of several runs."""
    best = float("inf")
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - start)
    return best


def first_model(plate: Plate, patches: tuple[Patch, ...], band: tuple[float, float], **how: Any) -> dict[str, Any]:
    """Assemble and reduce a plate, and compare its transfers with direct solutions."""
    training = BasisTraining(tolerance=how.get("basis_tolerance", 1e-4))
    start = time.perf_counter()
    model = assemble_for(plate, patches, BOX, band, fineness=how.get("fineness"))
    assembly = time.perf_counter() - start
    reduced = reduce(model, BOX, band, training=training)[0]
    total = time.perf_counter() - start
    lines = LINES[(band[0] <= LINES) & (band[1] >= LINES)]
    some = lines[:: lines.size // 8]
    start = time.perf_counter()
    full = model.compliance(*MATERIAL, some)
    each = (time.perf_counter() - start) / some.size
    small = reduced.compliance(*MATERIAL, lines)
    rms = np.sqrt(np.mean(np.abs(small) ** 2, axis=-1, keepdims=True))
    difference = float((np.abs(reduced.compliance(*MATERIAL, some) - full) / rms).max())
    found = {
        "unknowns": model.size,
        "energy_dropped": model.dropped,
        "coordinates": reduced.size,
        "assembly_s": assembly,
        "first_model_s": total,
        "direct_s_all_lines": each * lines.size,
        "difference_over_rms": difference,
        "certified_error": reduced.error,
    }
    if len(patches) == 2:
        twin = Twin(DeclaredPlate(reduced), Instruments.of_patches(0, (1,), LOAD))
        found["frf_s"] = seconds(lambda: twin.frf(LocalLaws.of_material(*MATERIAL), lines), 5)
        found["frf_with_derivatives_s"] = seconds(
            lambda: twin.linearise(LocalLaws.of_material(*MATERIAL), lines), 5
        )
        found["ratio"] = found["direct_s_all_lines"] / found["frf_s"]
    return found


def with_effects() -> dict[str, Any]:
    """Operators of the paper's plate with every effect possible."""
    experiment = Experiment(
        title="benchmark",
        plate=PAPER,
        patch=PAIR,
        string=tuple(Attachment(point=point) for point in ((0.03, 0.187), (0.21, 0.187))),
        cable=(Attachment(point=(0.058, 0.03)),),
        acquisition=Acquisition(
            module="NI-9234", sample_rate=8e3, input_resistance=305e3, input_capacitance=1.2e-10
        ),
        protocol=Protocol(
            sweep="linear",
            band=BAND,
            sweep_duration=2.0,
            tail=0.4,
            repeats=3,
            ramp_rate=0.4,
            temperatures=(20.0, 40.0),
            directions=("up", "down"),
            levels=(1.0, 2.0),
        ),
        oven=OvenDeclaration(room_temperature=22.0),
    )
    start = time.perf_counter()
    operators, full, vectors = reduce_with_effects(experiment, BOX)
    return {
        "unknowns": full.unknowns.size,
        "candidates": vectors.shape[1],
        "coordinates": operators.size,
        "first_model_s": time.perf_counter() - start,
        "certified_error_over_peak": operators.error,
    }


def main() -> int:
    """Print and store the figures; status 1 if answers differ by more than the error stated."""
    panel = {"fineness": Fineness(tolerance=3e-8), "basis_tolerance": 1e-3}
    with threadpool_limits(1):
        figures = {
            "update": first_model(PAPER, PAIR, BAND),
            "panel of six actuators": first_model(PAPER, SIX, (15.4, 1170.0), **panel),
            "trim with hole and turned patches": first_model(TRIM, TRIM_PATCHES, BAND),
        }
        if "--effects" in sys.argv[1:]:
            figures["with effects"] = with_effects()
    figures["memory"] = {"peak_mib": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0}
    RESULT.parent.mkdir(exist_ok=True)
    RESULT.write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")
    for name, rows in figures.items():
        print(name)
        for key, value in rows.items():
            print(f"    {key:30} {value:.6g}")
    plain = [rows for rows in figures.values() if "difference_over_rms" in rows]
    same = all(rows["difference_over_rms"] <= 2.0 * rows["certified_error"] for rows in plain)
    print(f"{'same' if same else 'ANOTHER'} result; {RESULT}")
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
