"""Plates of a trial: polymer plates of random geometry on which every effect of the library is possible."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from analysis.experiment import Attachment, Patch, Plate, Point
from simulation.meshing.recipe import MeshRecipe
from simulation.shell.fineness import Fineness

PATCH = 0.02
"""Edge of every patch, m."""
CLEAR = 0.012
"""Between two patches along either axis, and between one and the edge, m: the first sensor can be moved."""
MODES = (11.0, 15.0)
"""How many modes the band holds, by Weyl's law, at room temperature: to tell effects apart."""
LOWEST = 100.0
"""Hz, where bands begin."""
OTHER_MESH = Fineness(MeshRecipe(spacing=0.055, strip=1.07, edge_strip=1.27, growth=0.9), degree=9, tolerance=2e-9)
"""How the plates that are measured are meshed: other cells and another degree than the twin's."""


@dataclass(frozen=True)
class PlateKind:
    """What the campaigns on one plate share.

    Attributes
    ----------
    plate : Plate
    patches : tuple of Patch
    strings, cables : tuple of Attachment
    hidden : tuple of float
        An undeclared point on which a hidden effect may act, m.
    band : tuple of float
        Hz.
    """

    plate: Plate
    patches: tuple[Patch, ...]
    strings: tuple[Attachment, ...]
    cables: tuple[Attachment, ...]
    hidden: Point
    band: tuple[float, float]

    def record(self) -> dict[str, Any]:
        """Return it for a file."""
        return {
            "plate": self.plate.model_dump(),
            "patch": [patch.model_dump() for patch in self.patches],
            "string": [attached.point for attached in self.strings],
            "cable": [attached.point for attached in self.cables],
            "hidden": self.hidden,
            "band": self.band,
        }


def draw_plate(rng: np.random.Generator) -> PlateKind:
    """Draw a plate of 2.5 to 3.5 mm with an actuator and one or two sensors, two strings and a cable."""
    a, b = (round(float(rng.uniform(*limits)), 3) for limits in ((0.21, 0.27), (0.17, 0.21)))
    thickness = round(float(rng.uniform(0.0025, 0.0035)), 4)
    density = float(rng.uniform(900.0, 1300.0))
    plate = Plate(length_x=a, length_y=b, thickness=thickness, mass=round(density * a * b * thickness, 5))
    left, right = float(rng.uniform(0.030, 0.050)), a - float(rng.uniform(0.030, 0.050))
    spare = b - 2.0 * CLEAR - 3.0 * PATCH - 2.0 * CLEAR
    shares = spare * np.sort(rng.uniform(0.0, 1.0, 3))
    rows = [CLEAR + 0.5 * PATCH + k * (PATCH + CLEAR) + float(share) for k, share in enumerate(shares)]
    places = [("A1", "actuator", (right, rows[2])), ("S1", "sensor", (left, rows[0]))]
    if rng.random() < 0.5:
        places.append(("S2", "sensor", (right, rows[1])))
    patches = tuple(
        Patch.model_validate(
            {"id": name, "role": role, "center": _millimetres(*at), "size": (PATCH,) * 2, "thickness": 5e-4}
        )
        for name, role, at in places
    )
    along = float(rng.uniform(0.018, 0.026))
    return PlateKind(
        plate=plate,
        patches=patches,
        strings=tuple(Attachment(point=_millimetres(x * a, b - 0.004)) for x in (0.12, 0.86)),
        cables=(Attachment(point=_millimetres(left + along, rows[0] + 0.3 * along)),),
        hidden=_millimetres(a * float(rng.uniform(0.35, 0.65)), b * float(rng.uniform(0.3, 0.8))),
        band=(LOWEST, _band_end(plate, float(rng.uniform(*MODES)))),
    )


def _band_end(plate: Plate, modes: float, youngs_modulus: float = 1.9e9) -> float:
    """Where a free plate has so many modes by Weyl's law, N = S f sqrt(3) / (h c), to 10 Hz."""
    speed = np.sqrt(youngs_modulus / (plate.density * (1.0 - 0.38**2)))
    end = modes * plate.thickness * speed / (np.sqrt(3.0) * plate.area)
    return float(np.round(end, -1))


def _millimetres(x: float, y: float) -> Point:
    return round(float(x), 3), round(float(y), 3)
