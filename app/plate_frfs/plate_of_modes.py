"""A declared plate whose natural frequencies are known, without any FRF.

Natural frequencies and damping over temperature, from a table or from ``plate.toml``.
"""

import csv
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from analysis.arrays import Real
from analysis.declaration.strict import TEMPERATURES
from analysis.declaration.transducers import Drive
from analysis.experiment import Experiment, OvenDeclaration, Protocol
from analysis.geometry.loop import GeometryError
from analysis.recordings.frf_campaign import ModesAtTemperature
from app.files.bad_file import ResultFileError
from app.files.campaign_error import CampaignFileError, Problem
from app.files.declarations.plate import NAME, ModesOfPlate, plate_file, read_plate_measurement
from app.files.measurements.text import decoded
from app.files.parsed_text import read_bytes
from app.files.provenance import sha256
from app.plate_frfs.given_campaign import declared_experiment

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


COLUMNS = {
    "sigma_frequency": r"(sigma|std|σ|unc\w*|err\w*|u)[\W_]*(of[\W_]*)?f(req\w*)?(?![a-z])",
    "sigma_damping_ratio": r"(sigma|std|σ|unc\w*|err\w*|u)[\W_]*(of[\W_]*)?(damp\w*|zeta|ζ)",
    "sigma_loss_factor": r"(sigma|std|σ|unc\w*|err\w*|u)[\W_]*(of[\W_]*)?(loss|eta|η)",
    "temperature": r"(temp\w*|t)(?![a-z])",
    "damping_ratio": r"(damp\w*|dämpf\w*|zeta|ζ)",
    "loss_factor": r"(loss|verlust|eta|η)",
    "mode": r"(mode|number|no|nr|n)(?![a-z])",
    "frequency": r"f(req\w*)?(?![a-z])",
    "status": r"status(?![a-z])",
}
"""How the names of columns begin, in small letters, as they are looked for."""
UNITS = {
    "°c": 1.0,
    "degc": 1.0,
    "c": 1.0,
    "hz": 1.0,
    "khz": 1e3,
    "rad/s": 0.5 / np.pi,
    "%": 0.01,
    "-": 1.0,
    "1": 1.0,
}
"""Of columns, in square brackets or as the last word of the name; °C, Hz and shares where a name has none."""
OTHER_UNITS = r"k|°f|degf|f|mhz|rpm|1/min|s|ms"
"""That a name in round brackets is no remark: such numbers would be taken for °C and Hz."""
NEEDED = ("temperature", "frequency")
SURE = ("", "kept", "confirmed")
"""Words in a column of status with which a mode counts; others are weak."""
LARGEST_TABLE = 10_000_000
"""Bytes of a table of modes."""

Row = dict[str, float]


def modes_of_table(path: Path) -> list[ModesAtTemperature]:
    """Read a table with a mode in each row.

    Parameters
    ----------
    path : Path
        Text with commas, semicolons or tabs; the first line names the columns: temperature and frequency, and as
        far as they are known damping_ratio or loss_factor, the standard deviations (sigma_frequency, ...) and
        mode, the number. ``modes.csv`` of flexura identify is one: its weak modes are left out.

    Returns
    -------
    list of ModesAtTemperature

    Raises
    ------
    ResultFileError
        Naming the row and the column of what cannot be.
    """
    if not path.is_file():
        raise ResultFileError(f"{path}: no such file; a table of modes is wanted, as CSV")
    try:
        content = read_bytes(path, LARGEST_TABLE)
    except (OSError, ValueError) as error:
        raise ResultFileError(f"{path}: not readable as a table of modes ({error})") from error
    if content.startswith(b"PK"):
        raise ResultFileError(f"{path}: a workbook, no text; save its sheet as CSV")
    lines = _lines(decoded(content))
    if len(lines) < 2:
        raise ResultFileError(f"{path}: {len(lines)} lines; a line with names and one for each mode are wanted")
    separator = max(";\t,", key=lines[0].count)
    names, *rows = csv.reader(lines, delimiter=separator)
    places = _places(path, names)
    factors = {name: _factor(path, names[place]) for name, place in places.items()}
    _require_cells(path, names, rows)
    commas = separator != "," and any(re.search(r"\d,\d", cell) for row in rows for cell in row)
    decimal = "," if commas else ""
    # flexura identify numbers the modes that it found, not those that there are
    unused = ("status", "mode") if "status" in places else ()
    found = []
    for number, cells in enumerate(rows, start=2):
        word = _cell(cells, places.get("status"))
        if word.lower() not in SURE:
            continue
        row: Row = {}
        for name, place in places.items():
            text = _cell(cells, place).strip()
            if name in unused or not text or text.lower() in ("nan", "-", "–"):
                continue
            if decimal and "." in text:
                raise ResultFileError(
                    f"{path}: row {number}: {names[place].strip()} = {text!r}; others of its numbers have a "
                    "decimal comma: write all of them in one way, without marks of thousands"
                )
            row[name] = _value(path, number, names[place], text.replace(decimal, ".") if decimal else text)
            row[name] *= factors[name]
        lacking = [name for name in NEEDED if name not in row]
        if lacking:
            raise ResultFileError(f"{path}: row {number}: no {lacking[0]}; each needs temperature and frequency")
        found.append(row)
    if not found:
        raise ResultFileError(
            f"{path}: all its modes are weak; identify with a wider band, or correct their status"
        )
    try:
        return _by_temperature(found, _are_viscous(found))
    except ValueError as error:
        raise ResultFileError(f"{path}: {error}") from error


def _lines(text: str) -> list[str]:
    return [line for line in text.splitlines() if line.strip() and line.strip()[0] != "#"]


def _require_cells(path: Path, names: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Refuse rows with more values than there are names: with a decimal comma the next value would be taken."""
    for number, cells in enumerate(rows, start=2):
        if any(cell.strip() for cell in cells[len(names) :]):
            raise ResultFileError(
                f"{path}: row {number}: {len(cells)} values below {len(names)} names. If commas are decimal marks "
                "and stand between the values, too, put semicolons between them"
            )


def _are_viscous(rows: list[Row]) -> bool:
    """Whether frequencies are those of viscous modes, |pole| / 2 pi: so they are beside damping ratios.

    Where there are loss factors, too, they tell: 2 zeta beside viscous frequencies, Im k / Re k beside hysteretic
    ones (`analysis.identification.modes`), which is larger by a share of 1.5 zeta^2.
    """
    zeta = np.array([row.get("damping_ratio", np.nan) for row in rows])
    loss = np.array([row.get("loss_factor", np.nan) for row in rows])
    if np.isnan(loss).all():
        return bool(np.isfinite(zeta).any())
    both = np.isfinite(zeta) & np.isfinite(loss) & (np.abs(zeta) < 0.7)
    zeta, loss = zeta[both], loss[both]
    hysteretic = 2.0 * zeta * np.sqrt(1.0 - zeta**2) / (1.0 - 2.0 * zeta**2)
    return bool(zeta.size and np.abs(loss - 2.0 * zeta).sum() < np.abs(loss - hysteretic).sum())


def is_table_of_modes(path: Path) -> bool:
    """Whether the first line of a text names a temperature and a frequency, and no part of an FRF."""
    if path.suffix.lower() not in (".csv", ".txt", ".tsv"):
        return False
    try:
        first = _lines(decoded(read_bytes(path, LARGEST_TABLE)))[0]
    except (OSError, ValueError, IndexError):
        return False
    names = [name.strip().lower() for name in first.split(max(";\t,", key=first.count))]
    told = [any(re.match(COLUMNS[key], name) for name in names) for key in NEEDED]
    return all(told) and not any(re.search(PARTS_OF_FRFS, name) for name in names)


PARTS_OF_FRFS = r"(?<![a-z])(re|real|im|imag|mag|magnitude|phase|abs|coh\w*)(?![a-z])"


def _places(path: Path, names: list[str]) -> dict[str, int]:
    places: dict[str, int] = {}
    for place, name in enumerate(names):
        plain = name.strip().lower()
        for key, words in COLUMNS.items():
            if key not in places and re.match(words, plain):
                places[key] = place
                break
    lacking = [key for key in NEEDED if key not in places]
    if lacking:
        raise ResultFileError(
            f"{path}: no column {lacking[0]!r}; it has {', '.join(names[:12])}. Name the columns temperature, "
            "frequency, damping_ratio or loss_factor, sigma_frequency, ..., mode"
        )
    return places


def _cell(cells: list[str], place: int | None) -> str:
    return cells[place].strip() if place is not None and place < len(cells) else ""


def _value(path: Path, row: int, name: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not np.isfinite(value):
        raise ResultFileError(f"{path}: row {row}: {name} = {text!r}; a number is wanted, or nothing")
    return value


def _factor(path: Path, name: str) -> float:
    """Return what a column's numbers are multiplied with; ResultFileError for a unit that is not known."""
    plain = name.strip().lower()
    bracket = re.search(r"\[([^\]]*)\]", plain)
    round_one = re.search(rf"\((?:{OTHER_UNITS})\)", plain)
    if bracket is None and round_one is not None:
        bracket = re.search(r"\(([^)]*)\)", plain)
    if bracket is None:
        return 0.01 if "%" in plain else 1e3 if "khz" in plain else UNITS["rad/s"] if "rad/s" in plain else 1.0
    unit = bracket[1].strip()
    if unit in ("k", "°f", "degf", "f"):
        raise ResultFileError(
            f"{path}: column {name.strip()!r}: temperatures in °C are wanted: K - 273.15, or (°F - 32) / 1.8"
        )
    if unit and unit not in UNITS:
        raise ResultFileError(
            f"{path}: column {name.strip()!r}: unit {unit!r}; allowed: °C, Hz, kHz, rad/s, % and none"
        )
    return UNITS.get(unit, 1.0)


def modes_declared(said: Iterable[ModesOfPlate], folder: Path) -> list[ModesAtTemperature]:
    """Return the modes of a declaration, those of the tables that it names included.

    Parameters
    ----------
    said : iterable of ModesOfPlate
    folder : Path
        Of the declaration.

    Returns
    -------
    list of ModesAtTemperature

    Raises
    ------
    ResultFileError
        For a table that cannot be read.
    ValueError
        For modes that cannot be.
    """
    found: list[ModesAtTemperature] = []
    for one in said:
        if one.file is not None:
            found += modes_of_table(folder / one.file)
            continue
        keys = ("frequency", "sigma_frequency", "damping_ratio", "sigma_damping_ratio", "loss_factor")
        rows: list[Row] = []
        for number in range(len(one.frequency or ())):
            row = {"temperature": float(one.temperature or 0.0)}
            for key in (*keys, "sigma_loss_factor", "mode"):
                values = getattr(one, key)
                if values is not None:
                    row[key] = float(values[number] if isinstance(values, tuple) else values)
            rows.append(row)
        found += _by_temperature(rows, one.damping_ratio is not None)
    return found


def _by_temperature(rows: list[Row], viscous: bool) -> list[ModesAtTemperature]:
    """Group modes by temperature, to a tenth of a kelvin; ValueError for what cannot be."""
    low, high = TEMPERATURES
    groups: dict[float, list[Row]] = {}
    for row in rows:
        if not low <= row["temperature"] <= high:
            raise ValueError(f"temperature {row['temperature']:g} °C; allowed: {low:g} to {high:g}")
        if not 0.1 <= row["frequency"] <= 1e6:
            raise ValueError(f"frequency {row['frequency']:g} Hz; allowed: 0.1 to 1e6")
        groups.setdefault(round(row["temperature"], 1), []).append(row)
    return [_modes(groups[key], viscous) for key in sorted(groups)]


def _modes(rows: list[Row], viscous: bool) -> ModesAtTemperature:
    rows = sorted(rows, key=lambda row: row["frequency"])

    def column(name: str) -> Real:
        return np.array([row.get(name, np.nan) for row in rows])

    frequency, sigma = column("frequency"), column("sigma_frequency")
    loss, sigma_loss = column("loss_factor"), column("sigma_loss_factor")
    if viscous:
        zeta = column("damping_ratio")
        if (zeta[np.isfinite(zeta)] >= 0.7).any():
            raise ValueError(
                f"damping_ratio {np.nanmax(zeta):g}; below 0.7 is allowed: % stands in the name of its column"
            )
        known = np.isfinite(zeta)
        k_real = 1.0 - 2.0 * np.nan_to_num(zeta) ** 2  # Re k of a viscous pole over |pole|^2
        k_imag = 2.0 * np.nan_to_num(zeta) * np.sqrt(1.0 - np.nan_to_num(zeta) ** 2)
        frequency = frequency * np.sqrt(k_real)
        loss = np.where(known, k_imag / k_real, np.nan)
        sigma_loss = 2.0 * column("sigma_damping_ratio")
    return ModesAtTemperature(
        float(np.mean([row["temperature"] for row in rows])),
        frequency,
        sigma,
        loss,
        sigma_loss,
        np.array([int(row.get("mode", 0)) for row in rows]),
    )
