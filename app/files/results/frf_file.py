"""``frf.h5``: the FRFs of a campaign, and the experiment they belong to."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from analysis.experiment import Experiment
from analysis.recordings.frf import Frf
from app.files.atomic import atomic_hdf5
from app.files.hdf5_file import result_file
from app.files.provenance import stamp
from app.files.values import read_value, write_value


def save_frf(target: Path, experiment: Experiment, frf: Frf, made_from: Mapping[str, Any]) -> None:
    """Write FRFs, whole or not at all.

    Parameters
    ----------
    made_from : mapping
        Provenance.
    """
    with atomic_hdf5(target) as file:
        stamp(file, made_from)
        file.attrs["experiment"] = experiment.model_dump_json()
        write_value(file.create_group("frf"), frf)


def load_experiment(path: Path) -> Experiment:
    """Read the experiment alone; ResultFileError where the file is something else."""
    with result_file(path, "update") as file:
        return Experiment.model_validate_json(str(file.attrs["experiment"]))


def load_frf(path: Path) -> tuple[Experiment, Frf]:
    """Read back what `save_frf` wrote; ResultFileError where the file is something else."""
    with result_file(path, "update") as file:
        experiment = Experiment.model_validate_json(str(file.attrs["experiment"]))
        return experiment, read_value(file["frf"], Frf)
