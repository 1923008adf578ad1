"""The twin of a declared experiment, its reduced basis taken from the cache where it is there."""

import numpy as np
from numpy.typing import NDArray

from analysis.experiment import Experiment, Plate
from analysis.plate_material import material_box
from app.files.basis_cache import basis_file, cached_reduction
from app.progress import Report
from simulation.twin import Twin

SHAPE_POINTS = 32
"""Points along the longer side of the box around a plate on which its mode shapes are known."""


def campaign_twin(experiment: Experiment, report: Report) -> Twin:
    """Twin of a campaign's plate over its band, certified over its material's box; its shapes known on a grid."""
    return Twin.of(
        experiment,
        cached_reduction(
            experiment.plate,
            experiment.patch,
            material_box(experiment.plate.material),
            experiment.protocol.band,
            points=shape_points(experiment.plate),
            field_certified=False,
            progress=report,
        ),
    )


def twin_is_built(experiment: Experiment) -> bool:
    """Whether `campaign_twin` would find its reduced model in the cache."""
    plate = experiment.plate
    file = basis_file(
        plate,
        experiment.patch,
        material_box(plate.material),
        experiment.protocol.band,
        shape_points(plate),
        field_certified=False,
    )
    return file.is_file()


def shape_points(plate: Plate) -> NDArray[np.float64]:
    """Points of an even grid over the box around a plate that lie on it, edges included, x slowest, (K, 2), m."""
    sides = np.array([plate.length_x, plate.length_y])
    counts = np.maximum(np.round(SHAPE_POINTS * sides / sides.max()), 8).astype(int)
    axes = [np.linspace(low, high, n) for low, high, n in zip(*plate.bounds, counts, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    return points[plate.contains(points)]
