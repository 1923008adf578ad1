"""The twin of a declared experiment, its reduced basis taken from the cache where it is there."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.experiment import Experiment, Plate
from analysis.plate_material import material_box
from app.files.basis_cache import basis_file, cached_reduction, load_plate_basis
from app.progress import Report
from simulation.reduction.plate_basis import PlateBasis
from simulation.shell.footprints import attached_disc
from simulation.twin.plain_twin import Twin

SHAPE_POINTS = 32
"""Points along the longer side of the box around a plate on which its mode shapes are known."""


def campaign_twin(experiment: Experiment, report: Report) -> Twin:
    """Twin of a campaign's plate over its band, certified over its material's box; its shapes known on a grid."""
    return Twin.of(experiment, cached_reduction(**_asked(experiment), progress=report))


def plate_basis(experiment: Experiment, report: Report) -> PlateBasis | None:
    """Functions and vectors behind the twin of `campaign_twin`, which is made where it is not in the cache."""
    asked = _asked(experiment)
    file = basis_file(**asked)
    found = load_plate_basis(file)
    if found is None:
        cached_reduction(**asked, progress=report)
        found = load_plate_basis(file)
    return found


def twin_is_built(experiment: Experiment) -> bool:
    """Whether `campaign_twin` would find its reduced model in the cache."""
    return basis_file(**_asked(experiment)).is_file()


def _asked(experiment: Experiment) -> dict[str, Any]:
    """Return what a campaign asks of the plate's reduced model."""
    plate = experiment.plate
    return {
        "plate": plate,
        "patches": experiment.patch,
        "box": material_box(plate.material),
        "band": experiment.protocol.band,
        "footprints": experiment.footprints,
        "driven": experiment.driven,
        "attached": [attached_disc(plate, one) for one in (*experiment.string, *experiment.cable)],
        "points": shape_points(plate),
        "field_certified": False,
    }


def shape_points(plate: Plate) -> NDArray[np.float64]:
    """Points of an even grid over the box around a plate that lie on it, edges included, x slowest, (K, 2), m."""
    sides = np.array([plate.length_x, plate.length_y])
    counts = np.maximum(np.round(SHAPE_POINTS * sides / sides.max()), 8).astype(int)
    axes = [np.linspace(low, high, n) for low, high, n in zip(*plate.bounds, counts, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    return points[plate.contains(points)]
