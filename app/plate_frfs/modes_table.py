"""Natural frequencies and damping over temperature, from a table or from ``plate.toml``."""

import csv
import re
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from analysis.arrays import Real
from analysis.declaration.strict import TEMPERATURES
from analysis.recordings.frf_campaign import ModesAtTemperature
from app.files.bad_file import ResultFileError
from app.files.declarations.plate import ModesOfPlate
from app.files.parsed_text import read_text

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
        lines = [
            line for line in read_text(path, LARGEST_TABLE).splitlines() if line.strip() and line.strip()[0] != "#"
        ]
    except (OSError, ValueError) as error:
        raise ResultFileError(f"{path}: not readable as a table of modes ({error})") from error
    if len(lines) < 2:
        raise ResultFileError(f"{path}: {len(lines)} lines; a line with names and one for each mode are wanted")
    separator = max(";\t,", key=lines[0].count)
    names, *rows = csv.reader(lines, delimiter=separator)
    places = _places(path, names)
    factors = {name: _factor(path, names[place]) for name, place in places.items()}
    decimal = "," if separator != "," else ""
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
        first = next(
            line for line in read_text(path, LARGEST_TABLE).splitlines() if line.strip() and line.strip()[0] != "#"
        )
    except (OSError, ValueError, StopIteration):
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
    if bracket is None:
        return 0.01 if "%" in plain else 1e3 if "khz" in plain else UNITS["rad/s"] if "rad/s" in plain else 1.0
    unit = bracket[1].strip()
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
