"""A declared plate whose natural frequencies are known, without any FRF."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from analysis.declaration.transducers import Drive
from analysis.experiment import Experiment, OvenDeclaration, Protocol
from analysis.geometry.loop import GeometryError
from analysis.recordings.frf_campaign import ModesAtTemperature
from app.files.bad_file import ResultFileError
from app.files.campaign_error import CampaignFileError, Problem
from app.files.declarations.plate import NAME, plate_file, read_plate_measurement
from app.files.provenance import sha256
from app.plate_frfs.given_campaign import declared_experiment
from app.plate_frfs.modes_table import modes_declared, modes_of_table

BAND_BELOW, BAND_ABOVE = 0.5, 1.15
"""Band of the twin over the lowest and highest measured frequency: modes below the first one have to be counted,
and those above the last one lie among the measured ones for another modulus."""
NOWHERE = "unused"
"""Id of the drive and the sensor that a plate without any gets: modes need none, the reduced plate one of each."""


@dataclass(frozen=True)
class PlateOfModes:
    """A plate and its modes.

    Attributes
    ----------
    name : str
    experiment : Experiment
        With a massless drive and sensor where none are declared.
    modes : tuple of ModesAtTemperature
    hashes : dict
        SHA-256 of the files they were read from, by name.
    """

    name: str
    experiment: Experiment
    modes: tuple[ModesAtTemperature, ...]
    hashes: dict[str, str]


def read_plate_of_modes(plate: Path, table: Path | None = None) -> PlateOfModes:
    """Read a declared plate and its modes.

    Parameters
    ----------
    plate : Path
        The declaration, or the folder in which it is ``plate.toml``.
    table : Path, optional
        Modes that take the place of those declared.

    Returns
    -------
    PlateOfModes

    Raises
    ------
    CampaignFileError
        With all that is wrong with the declaration.
    ResultFileError
        For a table that cannot be read, or modes that cannot be.
    """
    file = plate_file(plate)
    if not file.is_file():
        raise ResultFileError(
            f"{file}: no such file; write one with: flexura new plate, or copy campaign.toml's tables"
        )
    said, rest = read_plate_measurement(file)
    hashes = {file.name: sha256(file)}
    try:
        if table is not None:
            modes = modes_of_table(table)
            hashes[table.name] = sha256(table)
        else:
            modes = modes_declared(said.modes, file.parent)
            hashes |= {one.file: sha256(file.parent / one.file) for one in said.modes if one.file is not None}
    except ValueError as error:
        raise ResultFileError(f"{file}: {error}") from error
    if not modes:
        problem = Problem(file.name, "modes", "nothing", "[[modes]] with temperature and frequency")
        raise CampaignFileError(file.parent, [problem])
    every = np.concatenate([one.frequency for one in modes])
    band = said.measurement.band or (BAND_BELOW * float(every.min()), BAND_ABOVE * float(every.max()))
    experiment = declared_experiment(file, said, _driven(rest), band)
    return PlateOfModes(
        name=file.parent.resolve().name if file.name == NAME else file.stem,
        experiment=_at(experiment, modes, band, room_declared="oven" in rest),
        modes=tuple(modes),
        hashes=hashes,
    )


def _driven(rest: dict[str, Any]) -> dict[str, Any]:
    """Add a drive and a sensor without mass where a table declares none."""
    patches = [one.get("role") for one in rest.get("patch", ()) if isinstance(one, dict)]
    added = dict(rest)
    place = _place(rest.get("plate"))
    if "actuator" not in patches and not rest.get("drive"):
        added["drive"] = [{"id": NOWHERE, "point": place}]
    if "sensor" not in patches and not rest.get("sensor"):
        added["sensor"] = [{"id": f"{NOWHERE} too", "kind": "displacement", "point": place}]
    return added


def _place(plate: Any) -> list[float]:
    """Return a point well inside a plate, m; the middle of its sides where what is declared is no plate yet."""
    from pydantic import ValidationError

    from analysis.declaration.plate import Plate

    try:
        declared = Plate.model_validate(plate)
    except (ValidationError, GeometryError):
        return [0.05, 0.05]
    low, high = (np.asarray(one) for one in declared.bounds)
    shares = [(x, y) for x in (0.31, 0.43, 0.61, 0.17, 0.83) for y in (0.29, 0.41, 0.63, 0.19, 0.81)]
    for share in shares:
        point = low + (high - low) * np.array(share)
        try:
            Drive(id=NOWHERE, point=(float(point[0]), float(point[1]))).check(declared)
        except GeometryError:
            continue
        return [float(point[0]), float(point[1])]
    return [0.05, 0.05]


def _at(
    experiment: Experiment, modes: Sequence[ModesAtTemperature], band: tuple[float, float], *, room_declared: bool
) -> Experiment:
    """Complete the protocol by the temperatures of the modes."""
    temperatures = tuple(sorted({round(one.temperature, 2) for one in modes}))
    record = max(1.0, 100.0 / (band[1] - band[0]))
    protocol = Protocol(
        sweep="logarithmic",
        band=band,
        sweep_duration=record,
        tail=0.0,
        repeats=1,
        ramp_rate=0.0,
        temperatures=temperatures,
        directions=("up",),
        levels=(1.0,),
    )
    changed: dict[str, Any] = {"protocol": protocol}
    if not room_declared and len(temperatures) == 1:
        changed["oven"] = OvenDeclaration(room_temperature=temperatures[0])
    return experiment.model_copy(update=changed)
