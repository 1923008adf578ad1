"""What ``--temperature`` says: one, a way between several, or a file of readings; whether filters cover it."""

import csv
import re
from pathlib import Path

import numpy as np

from analysis.estimation.quantities import TIMES, unit_behind_name
from analysis.material import MaterialLaws
from analysis.rendering.following import TemperatureProgramme
from app.files.bad_file import ResultFileError
from app.files.exports.shipment import Shipment
from app.files.parsed_text import read_text

LARGEST_READINGS_FILE = 100_000_000
"""Bytes of a file of readings."""


def programme(said: str, duration: float) -> TemperatureProgramme:
    """Read temperatures over a piece of sound.

    Parameters
    ----------
    said : str
        ``20``, ``20:45``, ``20:45:30``, evenly spread over the sound, or a CSV file of seconds and °C.
    duration : float
        Of the sound, s.

    Raises
    ------
    ResultFileError
        For what is neither.
    """
    try:
        given = [float(word) for word in said.split(":")]
    except ValueError:
        return _readings(Path(said))
    if not np.isfinite(given).all():
        raise ResultFileError(f"--temperature {said}: allowed are finite numbers of °C")
    return TemperatureProgramme.spread(np.array(given), duration)


def _readings(path: Path) -> TemperatureProgramme:
    if not path.is_file():
        raise ResultFileError(
            f"--temperature {path}: neither °C, as in 20 or 20:45, nor a CSV file of seconds and °C"
        )
    rows: list[tuple[float, float]] = []
    heading: list[str] = []
    try:
        text = read_text(path, LARGEST_READINGS_FILE)
    except (OSError, ValueError) as error:
        raise ResultFileError(f"{path}: cannot be read ({error}); allowed: CSV of seconds and °C") from error
    separator = next((one for one in (";", "\t") if one in text), ",")
    for number, row in enumerate(csv.reader(text.splitlines(), delimiter=separator), start=1):
        if not row or row[0].startswith("#"):
            continue
        if len(row) > 2 and row[2].strip().isdigit():  # 0,20,5: another column, or a decimal comma?
            raise ResultFileError(
                f"{path}: line {number} is {separator.join(row)[:60]!r}, a third number; allowed: seconds,°C, "
                "or seconds;°C where commas are decimal"
            )
        try:
            # commas that do not separate are decimal ones, as German spreadsheets write them
            rows.append((float(row[0].replace(",", ".")), float(row[1].replace(",", "."))))
        except (ValueError, IndexError) as error:
            if not rows and number <= 2:
                heading = heading or row
                continue
            message = f"{path}: line {number} is {separator.join(row)[:60]!r}; allowed: seconds,°C"
            raise ResultFileError(message) from error
    if not rows:
        raise ResultFileError(f"{path}: holds no readings; allowed: CSV of seconds and °C")
    if any(re.search(OTHER_DEGREES, name, re.IGNORECASE) for name in heading[1:2]):
        raise ResultFileError(
            f"{path}: {heading[1].strip()!r}: temperatures in °C are wanted: K - 273.15, or (°F - 32) / 1.8"
        )
    try:
        return TemperatureProgramme(*(np.array(rows) * [_seconds(heading[0]) if heading else 1.0, 1.0]).T)
    except ValueError as error:
        raise ResultFileError(f"{path}: {error}") from error


OTHER_DEGREES = r"°\s*F|deg\s*F|fahrenheit|kelvin|[\[(]\s*[FK]\s*[\])]|_[FK]$"
HOURS, MINUTES = r"(^|[\s_/.([-])(h|hours?|stunden?|std)[\])]*$", r"(^|[\s_/.([-])(min|minutes?|minuten?)[\])]*$"


def _seconds(heading: str) -> float:
    """Seconds of one unit of the times below a heading: ``time [min]``, ``t_ms``; 1 where it names none."""
    plain = heading.strip().lower()
    for unit, pattern in ((3600.0, HOURS), (60.0, MINUTES)):
        if re.search(pattern, plain):
            return unit
    return TIMES[unit_behind_name(re.sub(r"[\[\]]", " ", plain).strip(), TIMES) or "s"]


def require_covered(sent: Shipment, laws: MaterialLaws, course: TemperatureProgramme) -> None:
    """Raise ResultFileError unless filters and laws cover all temperatures.

    Parameters
    ----------
    laws : MaterialLaws
        Of the panel's plate.

    Raises
    ------
    ResultFileError
        Where the temperature leaves what one of them covers.
    """
    held = sent.filters.input.temperature_range
    if sent.filters.weights.count == 1:  # one filter for all temperatures; its panel's range counts
        held = sent.panel.filters.operating_range
    for what, (low, high) in (("filters", held), ("laws", laws.temperature_range)):
        outside = course.temperature[(course.temperature < low - 1e-9) | (course.temperature > high + 1e-9)]
        if outside.size:
            raise ResultFileError(
                f"--temperature {outside[0]:g} °C is outside what the {what} cover, {low:g} to {high:g} °C"
            )
