"""Cache key of a reduced model: hash of all its inputs."""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict

import numpy as np
from numpy.typing import ArrayLike

from analysis.experiment import Patch, Plate
from analysis.material import MaterialBox
from simulation.reduction.basis_training import BasisTraining
from simulation.shell.fineness import Fineness
from simulation.shell.piezo_material import PIEZO_MATERIALS

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
