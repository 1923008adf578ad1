"""The twin of a declared experiment, its reduced basis taken from the cache where it is there."""

from analysis.experiment import Experiment
from analysis.material import MaterialBox
from app.files.basis_cache import cached_reduction
from app.progress import Report
from simulation.twin import Twin

UPDATING_BOX = MaterialBox((0.8e9, 4.0e9), (0.30, 0.49), (0.005, 0.15))
"""What thermoplastics from a cold to a warm car interior can be, with room for a fit to walk in."""


def campaign_twin(experiment: Experiment, report: Report) -> Twin:
    """Twin of a campaign's plate over its band, certified over `UPDATING_BOX`."""
    return Twin.of(
        experiment,
        cached_reduction(
            experiment.plate, experiment.patch, UPDATING_BOX, experiment.protocol.band, progress=report
        ),
    )
