"""At which temperature, in which direction and at which level an FRF was measured: declared, or in a name."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from analysis.arrays import Numbers
from analysis.declaration.strict import TEMPERATURES
from app.files.declarations.plate import FrfsOfPlate
from app.plate_frfs.source_files import FrfsOfFile

Direction = Literal["up", "down"]

NUMBER = r"(?:(?<![A-Za-z0-9.])[-+])?(?<![0-9.])\d+(?:[.,]\d+)?"
"""A number in a name. A sign counts behind a space, an underscore, a bracket or nothing: in ``frf-20C`` the stroke
joins two words."""
PARTS = {"temperature": NUMBER, "level": NUMBER, "direction": "up|down", "drive": r"[^\s_/]+?"}
USUAL = (
    rf"(?P<temperature>{NUMBER})\s*(?:°|deg)?\s*C(?![A-Za-z])"
    rf"(?:[\s_]+(?P<direction>up|down)(?![A-Za-z]))?(?:[\s_]+(?P<level>{NUMBER})\s*[VN](?![A-Za-z]))?"
)
"""Temperature as most name it, and what Flexura's exports have behind it: ``scan_21.5C``, ``20.01 C up 0.3 V``."""


@dataclass(frozen=True)
class MeasuredAt:
    """Of one FRF.

    Attributes
    ----------
    temperature : float
        Degrees Celsius.
    direction : str
        ``up`` or ``down``.
    level : float
        V or N; 1 where it is not known.
    drive : str
        Id of what drove; empty where neither the declaration nor a name says so.
    """

    temperature: float
    direction: Direction = "up"
    level: float = 1.0
    drive: str = ""


def circumstances(found: FrfsOfFile, path: Path, name: str, star: str, said: FrfsOfPlate) -> MeasuredAt:
    """Return the circumstances of an FRF.

    Parameters
    ----------
    found : FrfsOfFile
        Of its file.
    path : Path
        The file.
    name : str
        Of the FRF.
    star : str
        What the ``*`` of its key in ``sensors`` stands for; empty without one.
    said : FrfsOfPlate

    Returns
    -------
    MeasuredAt

    Raises
    ------
    ValueError
        Where no temperature is found, or one that cannot be, with what to write.
    """
    in_name = _in_names(path, name, said.pattern)
    temperature = _number("temperature", said.temperature, found, star)
    if temperature is None:
        temperature = in_name.get("temperature", found.temperature)
    if temperature is None:
        raise ValueError(
            f"{found.file}: no temperature, neither in its name nor in that of FRF {name!r}; give temperature in "
            '[[frf]], in °C or the name of an array in the file, or pattern = "{temperature}C"'
        )
    low, high = TEMPERATURES
    if not low <= temperature <= high:
        raise ValueError(
            f"{found.file}: temperature = {temperature:g} °C of {name!r}; allowed: {low:g} to {high:g}"
        )
    level = _number("level", said.level, found, star)
    if level is None:
        level = in_name.get("level", 1.0)
    if not 0.0 < level <= 1000.0:
        raise ValueError(f"{found.file}: level = {level:g} of {name!r}; allowed: above 0 to 1000 (V or N)")
    words = _words_in_names(path, name, said.pattern)
    way = said.direction
    if way not in ("up", "down"):
        way = "down" if (_number("direction", way, found, star) or 0.0) > 0.5 else "up"
    direction: Direction = "down" if words.get("direction", way) == "down" else "up"
    return MeasuredAt(temperature, direction, level, said.drive or words.get("drive", ""))


def _number(key: str, given: float | str | None, found: FrfsOfFile, star: str) -> float | None:
    """Return a number as declared, or from the array of the file that the declaration names."""
    if given is None or isinstance(given, float | int):
        return None if given is None else float(given)
    if given not in found.arrays:
        # an array with several rows has become columns: T[1], T[2], ...
        several = f"{given}[{star}]" if star else ""
        if several not in found.arrays:
            held = ", ".join(list(found.arrays)[:12]) or "no other numbers"
            raise ValueError(f"{found.file}: {key} = {given!r}, but the file has no such array; it holds: {held}")
        return _mean(key, several, found.arrays[several], found.file)
    values = found.arrays[given]
    if not star or len(values) == 1:
        return _mean(key, given, values, found.file)
    number = re.match(r"\d+", star)
    place = int(number[0]) if number else 0
    if not 1 <= place <= len(values):
        raise ValueError(
            f"{found.file}: {key} = {given!r} has {len(values)} values, but the FRFs go on to number {star!r}; "
            "one for each sweep is wanted"
        )
    return float(values[place - 1].real)


def _mean(key: str, name: str, values: Numbers, file: str) -> float:
    """Return the mean of readings during one sweep; ValueError where they are those of several."""
    real = np.asarray(values.real, dtype=float)
    if not np.isfinite(real).all() or (key == "temperature" and np.ptp(real) > MOST_WITHIN):
        raise ValueError(
            f"{file}: {key} {name!r} goes from {np.min(real):g} to {np.max(real):g}; one value for each sweep is "
            'wanted: with a "*" in a name of sensors, sensors = { "H[*]" = "S1" }, it is taken sweep by sweep'
        )
    return float(real.mean())


MOST_WITHIN = 5.0
"""K between readings during one sweep; more are those of several."""


def _in_names(path: Path, name: str, pattern: str | None) -> dict[str, float]:
    words = _words_in_names(path, name, pattern)
    return {key: float(words[key].replace(",", ".")) for key in ("temperature", "level") if key in words}


def _words_in_names(path: Path, name: str, pattern: str | None) -> dict[str, str]:
    """Return what the pattern finds in the name of the FRF, else in that of the file."""
    compiled = re.compile(USUAL if pattern is None else as_regular(pattern))
    stem = path.name.removesuffix("".join(path.suffixes[-1:]))
    if path.suffix.lower() == ".gz":
        stem = stem.rpartition(".")[0] or stem
    for text in (name, stem, path.parent.name):
        found = compiled.search(text)
        if found:
            return {key: word for key, word in found.groupdict().items() if word}
    return {}


def as_regular(pattern: str) -> str:
    """Turn a pattern with words in braces and ``*`` into a regular expression.

    Raises ValueError for other words in braces, and one that stands twice.
    """
    made = re.escape(pattern).replace(r"\*", ".*")
    named = re.findall(r"\\\{(.*?)\\\}", made)
    for word in named:
        if word not in PARTS or named.count(word) > 1:
            raise ValueError(f"pattern = {pattern!r}: {{{word}}}; allowed, once each: {', '.join(PARTS)}")
        made = made.replace(rf"\{{{word}\}}", f"(?P<{word}>{PARTS[word]})")
    return made
