"""The section of docs/verification.md that compares the twin with solids: python docs/solid_comparison.py."""

import json
from typing import Any

import numpy as np
from make_solid_references import FILE

from tests.simulation.verification.solids import SolidComparison

TITLE = "## Against solids"
HEAD = f"""{TITLE}

Natural frequencies of the twin beside those of three-dimensional elasticity: CalculiX, elements of 20 nodes, three
meshes with two to four layers, extrapolated (`docs/make_solid_references.py`; the plates are in
`docs/solid_cases.py`, the values beside `tests/simulation/verification/test_solids.py`).

- *extrapolated by*: largest distance of the finest mesh from the limit.
- *error*: of the twin, which is what plate theory leaves out.
- *left*: of it after the prediction from each mode's own shape, `mode_errors` of
  `tests/simulation/verification/solids.py`; see [the twin](theory/twin.md#what-the-theory-leaves-out).

| plate | modes | largest k h | extrapolated by | error, % | left, % | left, rms, % |
|---|---|---|---|---|---|---|
"""


def row(name: str, stored: dict[str, Any]) -> str:
    """Line of one plate."""
    found = SolidComparison.of(stored)
    (e, nu), plate = found.material, found.plate
    h = plate.thickness
    rigidity = e * h**3 / (12.0 * (1.0 - nu**2))
    largest = h * np.sqrt(2 * np.pi * found.solid[-1] * np.sqrt(plate.density * h / rigidity))
    spread = 100 * max(stored["extrapolated_by"])
    error, left = 100 * found.error, 100 * found.left
    rms = np.sqrt(np.mean(left**2))
    return (
        f"| {name} | {found.solid.size} | {largest:.2f} | {spread:.3f} % | {error.min():+.3f} to "
        f"{error.max():+.3f} | {left.min():+.3f} to {left.max():+.3f} | {rms:.4f} |"
    )


def section() -> str:
    """Compute all plates and return the section's text."""
    stored = json.loads(FILE.read_text(encoding="utf-8"))
    return HEAD + "\n".join(row(name, one) for name, one in stored.items()) + "\n"


if __name__ == "__main__":
    print(section())
