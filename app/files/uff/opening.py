"""A universal file opened by pyuff, after what that library cannot read is written in the way it can; its units.

Units are those of data set 164, and those that axes of functions name.
"""

import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyuff

from analysis.estimation.quantities import FREQUENCIES, TIMES, axis_scale
from app.files.parsed_text import read_bytes

DELIMITER = re.compile(rb" {4}-1[ \t]*(?:\r\n?|\n|\Z)")
"""Ends a line of its own; after binary samples there need not be a new one."""
BLANK = re.compile(rb"(?:[ \t]*[\r\n]|[\0\x1a])*")
"""Spaces without an end of line may be the beginning of a delimiter that was cut."""
TYPE = re.compile(rb" {0,5}(\d{1,6})(b?)[^\r\n]*(?:\r\n?|\n)")
LINE = re.compile(rb"[^\r\n]*(?:\r\n?|\n)")
HEAD_LINES = 11
"""Of the head of a data set, before the samples."""
BYTES = slice(31, 43)
"""Columns in the first line of a binary set that give the length of its samples; some programs' are wrong."""


EXPONENT = re.compile(rb"(?<=[\d.])[dD](?=[+-]?\d{1,3}(?!\d))")
"""Fortran's sign of an exponent in double precision."""
NO_SIGN = re.compile(rb"(\.\d+)([+-]\d{3})(?![\d.])")
"""Fortran drops the letter before an exponent of three digits: ``1.5-103``."""
HEADS = {58: 13, 15: 2, 164: 3, 2411: 2}
"""Lines of the data sets that are read, delimiter and number included, before those of numbers only."""
STEP_LINE = 8
"""In the head of a data set 58: number of points, first line and step."""


def data_sets(content: bytes) -> list[int]:
    """Types of the data sets, in order.

    Raises
    ------
    ValueError
        Where a set does not end, has no type, or something else stands between two: the file is damaged, or was
        cut short.
    """
    return [kind for kind, _, _, _ in spans(content)]


def spans(content: bytes) -> list[tuple[int, bool, int, int]]:
    """Type of every data set, whether its samples are binary, and the bytes from its delimiter on up to its end.

    Raises ValueError as `data_sets`.
    """
    found: list[tuple[int, bool, int, int]] = []
    place = _after_blank(content, 0)
    while place < len(content):
        begin = DELIMITER.match(content, place)
        kind = TYPE.match(content, begin.end()) if begin else None
        if begin is None or kind is None:
            lacks = "type of a data set" if begin else "    -1 that begins a data set"
            raise ValueError(f"byte {place}: no {lacks}, after {len(found)} of them; cut short or damaged?")
        ends = _end(content, kind)
        if ends is None:
            seen = f"data set {len(found) + 1} (type {int(kind[1])}, from byte {place})"
            raise ValueError(f"{seen} has no end; cut short?")
        found.append((int(kind[1]), bool(kind[2]), place, ends))
        place = _after_blank(content, ends)
    return found


def plain_exponents(content: bytes) -> bytes:
    """Return a universal file with the exponents of its numbers as ``1.0E-03``, not Fortran's ``1.0D-03``."""
    parts: list[bytes] = []
    done = 0
    for kind, binary, begin, end in spans(content):
        if kind not in HEADS:
            continue
        lines = content[begin:end].splitlines(keepends=True)
        body = len(lines) if binary else HEADS[kind]  # above it names stand, which may look like numbers
        changed = [
            _plain(line) if place >= body or (kind == 58 and place == STEP_LINE) else line
            for place, line in enumerate(lines)
        ]
        parts += [content[done:begin], *changed]
        done = end
    return b"".join([*parts, content[done:]])


def _plain(line: bytes) -> bytes:
    return NO_SIGN.sub(rb"\1E\2", EXPONENT.sub(b"E", line))


def _end(content: bytes, kind: re.Match[bytes]) -> int | None:
    """Return where the set with this first line ends, its delimiter included."""
    if kind[2]:
        samples = kind.end()
        for _ in range(HEAD_LINES):
            line = LINE.match(content, samples)
            samples = line.end() if line else len(content)
        declared = kind[0][BYTES].strip()
        after = samples + int(declared) if declared.isdigit() else samples
        for close in (DELIMITER.match(content, after + skip) for skip in (0, 1, 2)):
            if close:
                return close.end()
        found = DELIMITER.search(content, samples)
        return found.end() if found else None
    for close in DELIMITER.finditer(content, kind.end()):
        if content[close.start() - 1] in b"\r\n":
            return close.end()
    return None


def _after_blank(content: bytes, place: int) -> int:
    blank = BLANK.match(content, place)
    return blank.end() if blank else place


LARGEST_UFF_FILE = 2_000_000_000
"""Bytes above which a file is refused rather than read into memory."""


@contextmanager
def opened_uff(path: Path) -> Iterator[tuple[pyuff.UFF, list[int]]]:
    """Yield the file to read sets from, and the types of all its data sets in order.

    Yields
    ------
    file : pyuff.UFF
    kinds : list of int

    Raises
    ------
    ValueError
        Where it is damaged or too large.
    """
    content = read_bytes(path, LARGEST_UFF_FILE)
    kinds = data_sets(content)
    plain = plain_exponents(content)
    with tempfile.TemporaryDirectory(prefix="flexura-") as folder:
        source = path
        if plain != content:
            source = Path(folder) / "plain.uff"
            source.write_bytes(plain)
        file = pyuff.UFF(str(source))
        if kinds != [int(kind) for kind in np.atleast_1d(file.get_set_types())]:
            raise ValueError("a line within a data set ends as if the set did; damaged?")
        yield file, kinds


UNITS_SET = 164
METRES = {1: 1.0, 2: 0.3048, 3: 1.0, 4: 0.3048, 5: 1e-3, 6: 1e-2, 7: 0.0254, 8: 1e-3}
"""Length of one unit by the units code; code 9 is the user's own."""
LENGTHS = {1.0: "m", 0.3048: "ft", 1e-3: "mm", 1e-2: "cm", 0.0254: "in"}
NEWTONS = {
    1: 1.0,
    2: 4.4482216152605,
    3: 9.80665,
    4: 0.138254954376,
    5: 1e-3,
    6: 1e-2,
    7: 4.4482216152605,
    8: 9.80665,
}
"""Force of one unit by the units code."""
FORCES = {1.0: "N", 4.4482216152605: "lbf", 9.80665: "kgf", 1e-3: "mN", 0.138254954376: "pdl", 1e-2: "cN"}
FACTOR_ROUNDING = 1e-3
"""Relative difference of a factor from that of the units code that rounding in the file may cause."""
TIME, FREQUENCY = 17, 18
"""Specific data types of an abscissa."""
ROTATION = (19, 20)
"""Rotations per minute, and order."""
NAMELESS = ("", "NONE", "UNKNOWN")


@dataclass(frozen=True)
class FileUnits:
    """What one unit of the file is in SI.

    Attributes
    ----------
    metre : float
        Metres of one unit of length.
    newton : float
        Newtons of one unit of force.
    """

    metre: float = 1.0
    newton: float = 1.0

    def names(self, quantity: str) -> str:
        """Return the unit of a quantity whose axis names none; empty for SI units."""
        length, force = _named(LENGTHS, self.metre), _named(FORCES, self.newton)
        if self == FileUnits():
            return ""
        motion = {"displacement": length, "velocity": f"{length}/s", "acceleration": f"{length}/s2"}
        return (motion | {"force": force}).get(quantity, "")


def _named(units: dict[float, str], scale: float) -> str:
    return next(
        (name for one, name in units.items() if abs(one / scale - 1.0) < FACTOR_ROUNDING), f"{scale:g} SI units"
    )


def file_units(file: pyuff.UFF, kinds: list[int]) -> FileUnits:
    """Read the units of a file; SI where it has no data set 164.

    Parameters
    ----------
    kinds : list of int
        Types of its data sets.

    Raises
    ------
    ValueError
        For factors that are none, contradict the units code, or change within the file.
    """
    found = {_units(_one(file.read_sets(n))) for n, kind in enumerate(kinds) if kind == UNITS_SET}
    if len(found) > 1:
        raise ValueError(f"its data sets 164 declare several units ({found}); export it with one")
    return found.pop() if found else FileUnits()


def _units(data: dict[str, Any]) -> FileUnits:
    code, factors = int(data["units_code"]), (float(data["length"]), float(data["force"]))
    for what, factor, known in zip(("length", "force"), factors, (METRES, NEWTONS), strict=True):
        if not (np.isfinite(factor) and 1e-9 < factor < 1e9):
            raise ValueError(f"data set 164: {what} factor {factor:g}; allowed: 1e-9 to 1e9, units per SI unit")
        if code in known and abs(factor * known[code] - 1.0) > FACTOR_ROUNDING:
            raise ValueError(
                f"data set 164: units code {code} means {what} factor {1.0 / known[code]:g}, and {factor:g} "
                f"stands "
                "there; correct the set"
            )
    return FileUnits(1.0 / factors[0], 1.0 / factors[1])


def _one(data: Any) -> dict[str, Any]:
    first: dict[str, Any] = data[0] if isinstance(data, list) else data
    return first


def unit_of(data: dict[str, Any], axis: str) -> str:
    """Return the unit that an axis of a function names, ``abscissa`` or another; empty where it names none."""
    unit = str(data.get(f"{axis}_axis_units_lab", "")).strip()
    return "" if unit.upper() in NAMELESS else unit


def in_hertz(data: dict[str, Any]) -> float:
    """Hertz of one unit of a function's frequencies; ValueError for an axis of something else."""
    kind = int(data.get("abscissa_spec_data_type", FREQUENCY))
    if kind in ROTATION:
        raise ValueError(f"its abscissa (specific data type {kind}) is rotation, not frequency; export it in Hz")
    return axis_scale(unit_of(data, "abscissa") or "Hz", FREQUENCIES, "its abscissa")


def in_seconds(data: dict[str, Any]) -> float:
    """Seconds of one unit of a time response's times; ValueError for a unit that is not known."""
    return axis_scale(unit_of(data, "abscissa") or "s", TIMES, "its abscissa")
