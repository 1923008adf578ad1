"""Cache key of a reduced model: hash of all its inputs.

Settings of the reduction of a plate: training materials and tolerance.
"""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import ArrayLike

from analysis.experiment import Patch, Plate
from analysis.material import MaterialBox
from simulation.shell.fineness import Fineness
from simulation.shell.piezo_material import PIEZO_MATERIALS


@dataclass(frozen=True)
class BasisTraining:
    """Settings of a reduced model.

    Attributes
    ----------
    tolerance : float
        Error allowed, relative to a transfer's rms over the band.
    modulus_ratio, poisson_step : float
        Largest gaps between training materials along E (a ratio) and nu. With two steps from 0.8 to 4 GPa in
        place of the three of 1.72, errors between them are three to ten times as large.
    lines : int
        Number of frequencies at which responses are compared and decomposed.
    rounds : int
        Largest number of rounds, in each of which the error is measured and missing responses are added to the
        vectors.
    """

    tolerance: float = 1e-4
    modulus_ratio: float = 1.72
    poisson_step: float = 0.2
    lines: int = 200
    rounds: int = 3

    def materials(self, box: MaterialBox) -> list[list[tuple[float, float]]]:
        """(E, nu) that cover the box: those of Krylov spaces, then those of every round of corrections of modes.

        The first are the softest, which has most modes, at every nu of a grid. A stiffer plate moves nearly as a
        soft one does at a lower frequency. The others are the softest between two nu and, at ever larger E, by
        turns those between and those of the grid, which the stiffest are. The stiffer part is corrected after the
        softer one, and misses less then.
        """
        (e0, e1), (n0, n1) = box.youngs_modulus, box.poisson_ratio
        levels = np.geomspace(e0, e1, self._steps(e1 / e0) + 1)[1:]
        cells = int(np.ceil((n1 - n0) / self.poisson_step - 1e-6))
        n = np.linspace(n0, n1, cells + 1)
        between = 0.5 * (n[1:] + n[:-1])
        from_stiffest = [n if k % 2 == 0 or not cells else between for k in range(len(levels))]
        stiffer = [(x, y) for x, values in zip(levels, reversed(from_stiffest), strict=True) for y in values]
        corrected = [(e0, y) for y in between] + stiffer
        half = 2 * ((len(corrected) + 2) // 4)  # even: two are solved at a time
        groups = [[(e0, y) for y in n], corrected[:half], corrected[half:]]
        return [[(float(x), float(y)) for x, y in group] for group in groups if group]

    def _steps(self, ratio: float) -> int:
        """Return the number of steps along E: at least two, for metals too, whose resonances are sharp."""
        return max(2, int(np.ceil(np.log(ratio) / np.log(self.modulus_ratio) - 1e-6))) if ratio > 1.0 else 0


METHOD = 21
"""Version, increased whenever the same declaration would give another reduced model."""


CURVED = 2
"""The same for curved plates alone."""


def basis_key(
    plate: Plate,
    patches: Sequence[Patch],
    box: MaterialBox,
    band: tuple[float, float],
    points: ArrayLike | None = None,
    fineness: Fineness | None = None,
    training: BasisTraining | None = None,
    field_certified: bool = True,
) -> str:
    """SHA-256 over plate, patches, their material, mesh, training, box, band and points.

    Names and roles of patches are left out: they change no matrix.

    Parameters
    ----------
    band : (float, float)
        Hz.
    points : (K, 2) array_like, optional
        Points at which the deflection is computed, m.
    field_certified : bool
        Whether the deflection there counts in the error.

    Returns
    -------
    str
        64 hexadecimal digits.

    Raises
    ------
    KeyError
        For a patch of an unknown piezo material.
    """
    geometry = [patch.model_dump(exclude={"id", "role"}) for patch in patches]
    declared = {
        "method": METHOD,
        "plate": plate.model_dump(exclude={"material"}),  # the box replaces the constants of an isotropic material
        "patches": geometry,
        "materials": {patch.material: asdict(PIEZO_MATERIALS[patch.material]) for patch in patches},
        "box": asdict(box),
        "band": [float(edge) for edge in band],
        "fineness": asdict(fineness or Fineness()),
        "training": asdict(training or BasisTraining()),
    }
    if plate.curvature is not None:
        declared["surface"] = CURVED
    if plate.material is not None and plate.material.departure is not None:
        declared["orthotropy"] = asdict(plate.material.departure)
    digest = hashlib.sha256(json.dumps(declared, sort_keys=True, allow_nan=False).encode())
    if points is not None:
        digest.update(np.ascontiguousarray(points, dtype="<f8").tobytes())
    if not field_certified:
        digest.update(b"field not certified")
    return digest.hexdigest()
