"""The twin of a declared experiment, its reduced basis taken from the cache where it is there."""

import numpy as np
from numpy.typing import NDArray

from analysis.experiment import Experiment, Plate
from analysis.material import MaterialBox
from app.files.basis_cache import cached_reduction
from app.progress import Report
from simulation.twin import Twin

UPDATING_BOX = MaterialBox((0.8e9, 4.0e9), (0.30, 0.49), (0.005, 0.15))
"""What thermoplastics from a cold to a warm car interior can be, with room for a fit to walk in."""


SHAPE_POINTS = 32
"""Points along the longer side of the box around a plate on which its mode shapes are known."""


def campaign_twin(experiment: Experiment, report: Report) -> Twin:
    """Twin of a campaign's plate over its band, certified over `UPDATING_BOX`; its shapes known on a grid."""
    return Twin.of(
        experiment,
        cached_reduction(
            experiment.plate,
            experiment.patch,
            UPDATING_BOX,
            experiment.protocol.band,
            footprints=experiment.footprints,
            driven=range(sum(source.footprint is not None for source in experiment.inputs)),
            points=shape_points(experiment.plate),
            field_certified=False,
            progress=report,
        ),
    )


def shape_points(plate: Plate) -> NDArray[np.float64]:
    """Points of an even grid over the box around a plate that lie on it, edges included, x slowest, (K, 2), m."""
    sides = np.array([plate.length_x, plate.length_y])
    counts = np.maximum(np.round(SHAPE_POINTS * sides / sides.max()), 8).astype(int)
    axes = [np.linspace(low, high, n) for low, high, n in zip(*plate.bounds, counts, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    return points[plate.contains(points)]
