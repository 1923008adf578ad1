"""``modes.h5`` and ``modes.csv``: what was identified at every temperature, for Flexura and for people.

``frf.h5``: the FRFs of a campaign, and the experiment they belong to.
"""

import csv
import io
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.experiment import Experiment
from analysis.identification.modes import Modes, Rejected
from analysis.identification.over_temperature.tracked_modes import TrackedModes
from analysis.identification.pole_residue import named
from analysis.recordings.frf import Frf
from analysis.shapes.participation import ModeShapes
from app.files.atomic import atomic_hdf5, write_text
from app.files.hdf5_file import read_value, result_file, write_value
from app.files.provenance import read_stamp, stamp


@dataclass(frozen=True)
class _Sweep:
    """One sweep's `Modes` in parts that HDF5 can hold; see there."""

    poles: NDArray[np.complex128]
    residues: NDArray[np.complex128]
    covariance: NDArray[np.float64]
    terms: str
    coefficients: NDArray[np.complex128]
    status: tuple[str, ...]
    reason: tuple[str, ...]
    band: tuple[float, float]
    misfit: float
    lines: int
    rejected_poles: NDArray[np.complex128]
    rejected_reasons: tuple[str, ...]
    rejected_statuses: tuple[str, ...]
    confirmation: tuple[str, ...] = ()
    damping: str = ""
    corrected: NDArray[np.complex128] | None = None


@dataclass(frozen=True)
class _Track:
    """`TrackedModes` less its modes; see there."""

    temperature: NDArray[np.float64]
    direction: tuple[str, ...]
    level: NDArray[np.float64]
    channels: tuple[str, ...]
    track: NDArray[np.int64]
    start: int
    notes: tuple[str, ...]
    level_unit: str = "V"


ARRAYS = ("poles", "residues", "covariance", "coefficients")
SHARED = (*ARRAYS, "status", "reason", "band", "misfit", "lines", "confirmation", "damping", "corrected")


def save_modes(
    target: Path, tracked: TrackedModes, made_from: Mapping[str, Any], shapes: ModeShapes | None = None
) -> None:
    """Write tracked modes, whole or not at all; they rebuild their FRFs exactly when read back.

    Parameters
    ----------
    made_from : mapping
        Provenance.
    shapes : ModeShapes, optional
        Of a test at many places.
    """
    with atomic_hdf5(target) as file:
        stamp(file, made_from)
        parts = {name: getattr(tracked, name) for name in _Track.__dataclass_fields__}
        write_value(file.create_group("tracked"), _Track(**parts))
        if shapes is not None:
            write_value(file.create_group("shapes"), shapes)
        for number, modes in enumerate(tracked.modes):
            same = {name: getattr(modes, name) for name in SHARED}
            sweep = _Sweep(
                **same,
                terms=modes.terms.name,
                rejected_poles=np.array([r.pole for r in modes.rejected], dtype=complex),
                rejected_reasons=tuple(r.reason for r in modes.rejected),
                rejected_statuses=tuple(r.status for r in modes.rejected),
            )
            write_value(file.create_group(f"sweeps/{number:04d}"), sweep)


def load_modes(path: Path) -> TrackedModes:
    """Read back what `save_modes` wrote; ResultFileError where the file is something else."""
    with result_file(path, "identify") as file:
        parts = vars(read_value(file["tracked"], _Track))
        # a file of an earlier version has the reading of its poles in its provenance only
        damping = str(read_stamp(file).get("settings", {}).get("damping", "hysteretic"))
        modes = tuple(_modes(read_value(file["sweeps"][name], _Sweep), damping) for name in sorted(file["sweeps"]))
        return TrackedModes(**parts, modes=modes)


def modes_made_from(path: Path) -> dict[str, str]:
    """SHA-256 of the inputs that modes were identified from, by name; ResultFileError where it cannot be read."""
    with result_file(path, "identify") as file:
        return {str(name): str(digest) for name, digest in read_stamp(file)["inputs"].items()}


def load_shapes(path: Path) -> ModeShapes:
    """Read back the shapes of a test; ResultFileError where the file holds none."""
    with result_file(path, "identify") as file:
        return read_value(file["shapes"], ModeShapes)


def _modes(sweep: _Sweep, damping: str) -> Modes:
    same = {name: getattr(sweep, name) for name in SHARED} | {"damping": sweep.damping or damping}
    parts = zip(sweep.rejected_poles, sweep.rejected_reasons, sweep.rejected_statuses, strict=True)
    return Modes(
        **same,
        terms=named(sweep.terms),
        rejected=tuple(Rejected(complex(pole), reason, status) for pole, reason, status in parts),
    )


def write_table(target: Path, tracked: TrackedModes) -> None:
    """Write one row per sweep and mode as comma-separated text."""
    reading = tracked.reading()
    stream = io.StringIO()
    rows = csv.writer(stream, lineterminator="\n")
    names = (
        "frequency_hz",
        "sigma_frequency_hz",
        "damping_ratio",
        "sigma_damping_ratio",
        "loss_factor",
        "sigma_loss_factor",
    )
    level = f"level_{tracked.level_unit.lower()}"
    rows.writerow(["temperature_c", "direction", level, "mode", *names, "status", "confirmation", "reason"])
    for t, modes in enumerate(tracked.modes):
        reasons = modes.explanation()
        for j, pole in enumerate(tracked.track[t]):
            if pole >= 0:
                values = [f"{float(getattr(reading, name)[t, j]):.9g}" for name in names]
                place = [f"{tracked.temperature[t]:.4f}", tracked.direction[t], f"{tracked.level[t]:g}", j + 1]
                rows.writerow([*place, *values, modes.status[pole], modes.confirmed_word(pole), reasons[pole]])
    write_text(target, stream.getvalue())


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
