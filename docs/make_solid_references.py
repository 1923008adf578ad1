"""Make natural frequencies of plates as solids again: python docs/make_solid_references.py [--case NAME ...].

CalculiX (ccx, Debian's calculix-ccx) solves three meshes of C3D20R each, the frequencies are extrapolated
(Richardson) and stored beside the tests, which compare the twin with them. A case takes about three minutes.
"""

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np
from solid_cases import CASES, SolidCase
from solid_plate import frequencies, meshed

from analysis.arrays import Real
from analysis.experiment import Plate

FILE = Path(__file__).resolve().parents[1] / "tests" / "simulation" / "verification" / "solid_references.json"
REFINEMENTS = (2, 3, 4)
ORDERS = np.linspace(1.0, 6.0, 501)
"""Orders of convergence that are tried."""


def declared(case: SolidCase) -> Plate:
    """Return the plate with the mass of its solid without patches, kg."""
    for trial in np.geomspace(0.01, 20.0, 60):
        try:
            plate = Plate.model_validate({**case.plate, "mass": float(trial)})
        except ValueError:  # this mass is not plausible for this volume
            continue
        return plate.model_copy(update={"mass": case.material[2] * plate.volume * stretch(plate)})
    raise ValueError(f"{case.name}: no mass from 0.01 to 20 kg is plausible")


def stretch(plate: Plate) -> float:
    """Area of a curved plate over that of its projection; the plate is a rectangle."""
    if plate.curvature is None:
        return 1.0
    place, weight = np.polynomial.legendre.leggauss(12)
    x, y = (0.5 * side * (1.0 + place) for side in (plate.length_x, plate.length_y))
    points = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    area = np.sqrt(1.0 + (plate.slope(points) ** 2).sum(axis=1)).reshape(len(x), len(y))
    return float(0.25 * weight @ area @ weight)


def solved(case: SolidCase, refinement: int) -> tuple[Real, int]:
    """Frequencies of the elastic modes, Hz, and the number of nodes of one mesh."""
    plate = declared(case)

    def lift(places: Real) -> Real:
        flat, up = places[:, :2], places[:, 2:]
        normal = np.hstack([-plate.slope(flat), np.ones((len(flat), 1))])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        return np.hstack([flat, plate.height(flat)[:, None]]) + up * normal

    mesh = meshed(case.blocks, refinement, lift if plate.curvature else None)
    held = None if case.held is None else np.flatnonzero(np.abs(mesh.nodes[:, 0] - case.held) < 1e-9)
    rigid = 6 if held is None else 0
    return frequencies(mesh, case.materials, rigid + case.modes, held)[rigid:], len(mesh.nodes)


def extrapolated(found: Real) -> tuple[Real, Real]:
    """Limit of frequencies (3, K) as the cells shrink, and its relative distance from the finest mesh."""
    size = 1.0 / np.array(REFINEMENTS, float)
    powers = size[:, None] ** ORDERS
    wanted = (powers[0] - powers[1]) / (powers[1] - powers[2])
    seen = (found[0] - found[1]) / (found[1] - found[2])
    order = ORDERS[np.abs(seen[:, None] - wanted).argmin(axis=1)]
    share = size[2] ** order / (size[1] ** order - size[2] ** order)
    limit = found[2] - share * (found[1] - found[2])
    return limit, np.abs(found[2] / limit - 1.0)


def record(case: SolidCase) -> dict[str, Any]:
    """Compute a case and return what is stored of it."""
    found, nodes = zip(*(solved(case, refinement) for refinement in REFINEMENTS), strict=True)
    limit, spread = extrapolated(np.array(found))
    return {
        "plate": {**case.plate, "mass": declared(case).mass},
        "patches": list(case.patches),
        "youngs_modulus": case.material[0],
        "poisson_ratio": case.material[1],
        "nodes": list(nodes),
        "frequency": [float(f"{value:.8g}") for value in limit],
        "extrapolated_by": [float(f"{value:.2g}") for value in spread],
    }


def main() -> None:
    """Compute all cases, or some, and write them into the file; others keep their values."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    names = [case.name for case in CASES]
    parser.add_argument("--case", action="append", choices=names, metavar="NAME", help="; ".join(names))
    chosen = parser.parse_args().case or names
    stored = json.loads(FILE.read_text(encoding="utf-8")) if FILE.is_file() else {}
    for case in CASES:
        if case.name in chosen:
            stored[case.name] = record(case)
            print(case.name, max(stored[case.name]["extrapolated_by"]), flush=True)
            FILE.write_text(json.dumps(stored, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
