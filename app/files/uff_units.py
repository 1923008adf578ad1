"""Units of a universal file: data set 164, and the units that axes of functions name."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pyuff

from analysis.estimation.quantities import FREQUENCIES, TIMES, axis_scale

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
