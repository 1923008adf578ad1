"""FRFs of ``frf.h5``, which Flexura wrote itself, with their noise."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from analysis.arrays import Complex, Real
from analysis.experiment import Experiment
from analysis.recordings.frf import Frf
from analysis.recordings.frf_campaign import Noise
from app.files.hdf5_file import HDF5
from app.files.results.frf_file import load_frf
from app.plate_frfs.circumstances import Direction, MeasuredAt

ENDINGS, OWN_NAME = (".h5", ".hdf5"), "frf.h5"


def is_own(path: Path) -> bool:
    """Whether a file is to be read as one that Flexura wrote: by its seal, or by its name, where that is missing.

    An HDF5 file of anybody else begins with HDF5's own signature; so do results of versions that wrote no seal,
    which are refused with what to do.
    """
    if path.suffix.lower() not in ENDINGS or not path.is_file():
        return False
    with path.open("rb") as file:
        return path.name == OWN_NAME or file.read(len(HDF5)) != HDF5


@dataclass(frozen=True)
class PlacedFrf:
    """One FRF of a plate: its ends, its circumstances and its noise, in SI units.

    Attributes
    ----------
    name : str
        File and name, for messages.
    output, source : int
        Which of `Experiment.outputs` and `Experiment.inputs`.
    at : MeasuredAt
    frequency : (F,) ndarray, Hz
    h : (F,) complex ndarray
    noise : str
        As in `analysis.recordings.frf_campaign.FrfSweep`.
    variance, coherence : (F,) ndarray
    repeats_dof : int
    sweep : str
        What tells sweeps of equal circumstances apart; empty where nothing does.
    """

    name: str
    output: int
    source: int
    at: MeasuredAt
    frequency: Real
    h: Complex
    noise: Noise
    variance: Real
    coherence: Real
    repeats_dof: int = 0
    sweep: str = ""


def own_frfs(path: Path, experiment: Experiment) -> list[PlacedFrf]:
    """Read all FRFs of a run's ``frf.h5`` that a plate declares.

    Parameters
    ----------
    path : Path
    experiment : Experiment
        Of the plate; drives and sensors are found by their ids.

    Returns
    -------
    list of PlacedFrf

    Raises
    ------
    ResultFileError
        For a file that cannot be read.
    ValueError
        For a sensor or a drive that is not among those of the file.
    """
    declared, frf = load_frf(path)
    ids, drives = [one.id for one in experiment.outputs], [one.id for one in experiment.inputs]
    named = [one.id for one in declared.inputs]
    for kind, wanted, there in (("sensor", ids, frf.channels), ("drive", [*drives], named)):
        strangers = [one for one in wanted if one not in there]
        if strangers:
            raise ValueError(
                f"{path.name}: no {kind} {strangers[0]!r}; it holds: {', '.join(there)}. Declare those of them "
                "that are wanted, by their ids"
            )
    return [
        _placed(path, frf, sweep, frf.channels.index(sensor), ids.index(sensor), drives.index(driven))
        for sweep in range(len(frf.temperature))
        for driven in (named[frf.driven_by[sweep]],)
        if driven in drives
        for sensor in ids
    ]


def _placed(path: Path, frf: Frf, sweep: int, row: int, output: int, source: int) -> PlacedFrf:
    direction: Direction = "down" if frf.direction[sweep] == "down" else "up"
    return PlacedFrf(
        name=f"{path.name}: {frf.label(row, sweep)} of sweep {sweep}",
        output=output,
        source=source,
        at=MeasuredAt(float(frf.temperature[sweep]), direction, float(frf.level[sweep])),
        frequency=frf.frequency,
        h=frf.h[sweep, row],
        noise="variance",
        variance=frf.variance[sweep, row],
        coherence=np.asarray(frf.coherence[sweep, row]),
        repeats_dof=0 if frf.repeats_dof is None else int(frf.repeats_dof[sweep]),
        sweep=f"{path.name} {sweep}",
    )
