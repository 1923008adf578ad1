"""What channels measure: SI units, the units that files use, and the names of ratios of two quantities."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from math import pi

from analysis.channel import UNITS, Quantity

GRAVITY = 9.80665
"""m/s2, the standard value."""

SCALES: dict[Quantity, dict[str, float]] = {
    "voltage": {"V": 1.0, "mV": 1e-3, "uV": 1e-6},
    "charge": {"C": 1.0, "nC": 1e-9, "pC": 1e-12},
    "force": {
        "N": 1.0, "mN": 1e-3, "kN": 1e3, "cN": 1e-2, "daN": 10.0, "dyn": 1e-5, "kgf": GRAVITY,
        "gf": 1e-3 * GRAVITY,
        "lbf": 4.4482216152605, "klbf": 4448.2216152605, "ozf": 0.27801385095378,
    },
    "displacement": {
        "m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "in": 0.0254, "mil": 2.54e-5, "ft": 0.3048,
    },
    "velocity": {
        "m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3, "um/s": 1e-6, "nm/s": 1e-9, "in/s": 0.0254, "ft/s": 0.3048,
    },
    "acceleration": {
        "m/s2": 1.0, "cm/s2": 1e-2, "mm/s2": 1e-3, "um/s2": 1e-6, "g": GRAVITY, "mg": 1e-3 * GRAVITY,
        "ug": 1e-6 * GRAVITY, "in/s2": 0.0254, "ft/s2": 0.3048,
    },
    "strain": {"m/m": 1.0, "mm/m": 1e-3, "um/m": 1e-6, "nm/m": 1e-9, "%strain": 1e-2},
    "pressure": {"Pa": 1.0, "hPa": 1e2, "MPa": 1e6, "mPa": 1e-3, "uPa": 1e-6, "kPa": 1e3, "bar": 1e5,
    "psi": 6894.757293168},
}  # fmt: skip
"""SI value of one unit, by quantity."""

TIMES = {"s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "ns": 1e-9}
"""Seconds of one unit."""

FREQUENCIES = {"Hz": 1.0, "kHz": 1e3, "MHz": 1e6, "rad/s": 0.5 / pi, "krad/s": 5e2 / pi}
"""Hertz of one unit."""

WORDS = {
    "volt": "V", "volts": "V", "v": "V", "mv": "mV", "millivolt": "mV", "millivolts": "mV",
    "newton": "N", "newtons": "N", "n": "N", "kn": "kN",
    "pounds": "lbf", "pound": "lbf", "lbs": "lbf", "lb": "lbf", "lbf": "lbf", "poundforce": "lbf",
    "kip": "klbf", "kips": "klbf", "kp": "kgf",
    "pascal": "Pa", "pascals": "Pa", "pa": "Pa", "coulomb": "C", "coulombs": "C",
    "meter": "m", "meters": "m", "metre": "m", "metres": "m", "in": "in", "mm": "mm", "inch": "in",
    "inches": "in", "micron": "um",
    "microns": "um", "mils": "mil", "feet": "ft", "foot": "ft",
    "m/s/s": "m/s2", "m/sec2": "m/s2", "m/sec/sec": "m/s2", "ms-2": "m/s2", "m/sec": "m/s", "ms-1": "m/s",
    "m/s2": "m/s2", "m/s": "m/s", "mm/s2": "mm/s2", "mm/s/s": "mm/s2", "mm/sec2": "mm/s2", "mm/s": "mm/s",
    "mm/sec": "mm/s", "in/sec": "in/s", "inch/s": "in/s", "inch/sec": "in/s", "ips": "in/s", "in/s/s": "in/s2",
    "in/sec2": "in/s2", "in/sec/sec": "in/s2", "inch/s2": "in/s2", "ips2": "in/s2", "fps": "ft/s",
    "ft/sec": "ft/s",
    "ft/sec2": "ft/s2", "g": "g", "gs": "g", "g's": "g", "gn": "g", "g_n": "g", "grms": "g", "gpk": "g",
    "strain": "m/m", "eps": "m/m", "ue": "um/m", "uε": "um/m", "με": "um/m", "ε": "m/m",
    "ustrain": "um/m", "microstrain": "um/m", "microepsilon": "um/m", "ueps": "um/m", "ustr": "um/m",
    "um/m": "um/m", "um/mm": "mm/m", "mstrain": "mm/m",
    "seconds": "s", "second": "s", "msec": "ms", "usec": "us", "milliseconds": "ms", "microseconds": "us",
    "nanoseconds": "ns", "minutes": "min", "hertz": "Hz", "hz": "Hz", "khz": "kHz",
    "cps": "Hz",
    "rad/sec": "rad/s", "radian/s": "rad/s", "radians/s": "rad/s", "radian/sec": "rad/s", "radians/sec": "rad/s",
    "rad/s": "rad/s", "1/s": "Hz",
}  # fmt: skip
"""Units as LabVIEW and others spell them, in small letters."""

EXACT_SPELLINGS = frozenset({*(name for scales in SCALES.values() for name in scales), *TIMES, *FREQUENCIES})
"""Units that stand for themselves, whatever WORDS makes of them in small letters: ``mN`` is no meganewton."""

SPELLINGS = (
    ("^", ""),
    ("**", ""),
    ("²", "2"),
    ("⁻", "-"),
    ("¹", "1"),
    ("µ", "u"),
    ("μ", "u"),
    ("·", ""),
    ("*", ""),
    ("⋅", ""),
    ("³", "3"),
)
"""Signs of units that are written in several ways."""

SENSITIVITY = re.compile(r"\s*([-+]?[\d.,]+(?:[eE][-+]?\d+)?)\s*([^\d\s./,(][^/]*)/(.+)")
"""Number, what the sensor gives, what it senses: ``100 mV/g``, ``10,2mV/(m/s²)``."""

NAMES: dict[tuple[Quantity, Quantity], str] = {
    ("displacement", "force"): "receptance",
    ("velocity", "force"): "mobility",
    ("acceleration", "force"): "accelerance",
    ("force", "displacement"): "dynamic stiffness",
    ("force", "velocity"): "impedance",
    ("force", "acceleration"): "apparent mass",
    ("pressure", "force"): "acoustic transfer function",
}
"""Of a response by what drives it (ISO 7626-1)."""


@dataclass(frozen=True)
class Unit:
    """A unit as a file or a data sheet writes it.

    Attributes
    ----------
    quantity : str
    scale : float
        SI value of one of it.
    """

    quantity: Quantity
    scale: float


def unit(text: str) -> Unit:
    """Read a unit: ``g``, ``mm/s``, ``m/s^2``, ``µm``; ValueError with those that are known."""
    plain = plain_unit(text)
    for quantity, scales in SCALES.items():
        if plain in scales:
            return Unit(quantity, scales[plain])
    known = ", ".join(name for scales in SCALES.values() for name in scales)
    raise ValueError(f"unit {text!r} is not known; allowed: {known}")


def axis_scale(text: str, scales: Mapping[str, float], axis: str) -> float:
    """Read a unit of times or frequencies.

    Parameters
    ----------
    text : str
        As the file or the declaration writes it.
    scales : dict of str to float
        `TIMES` or `FREQUENCIES`.
    axis : str
        For the message.

    Returns
    -------
    float
        Seconds or hertz of one unit.

    Raises
    ------
    ValueError
        For a unit that is not among them.
    """
    plain = plain_unit(text)
    if plain not in scales:
        raise ValueError(f"unit {text!r} of {axis} is not known; give unit, one of {', '.join(scales)}")
    return scales[plain]


BEHIND_NAMES = (
    ("krad/s", r"krad(/|_|_per_|\s+per\s+|p)s(ec)?\)?$"),
    ("rad/s", r"rad(/|_|_per_|\s+per\s+|p)s(ec)?\)?$|(^|[^a-z])(omega|ω)([^a-z]|$)"),
    ("kHz", r"khz\)?$"),
    ("ms", r"(^|[\s_/.(-])(ms|msec|millis(econds)?)\)?$"),
    ("us", r"(^|[\s_/.(-])([uµμ]s|usec|micros(econds)?)\)?$"),
    ("ns", r"(^|[\s_/.(-])(ns|nsec|nanos(econds)?)\)?$"),
)
"""Units of axes that stand behind names without square brackets: ``time_ms``, ``f/kHz``; ``omega`` means it."""


def unit_behind_name(name: str, scales: Mapping[str, float]) -> str:
    """Return the unit of an axis that its name ends with, empty where it names none.

    Parameters
    ----------
    name : str
        ``time_ms``, ``Frequency kHz``; variables of MATLAB can have no brackets.
    scales : dict of str to float
        `TIMES` or `FREQUENCIES`.
    """
    plain = name.strip().lower()
    return next((unit for unit, how in BEHIND_NAMES if unit in scales and re.search(how, plain)), "")


def is_unit(text: str) -> bool:
    """Whether a text is a unit that channels, times or frequencies may have."""
    plain = plain_unit(text)
    return plain in (*TIMES, *FREQUENCIES, "FS", "-", "1") or any(plain in scales for scales in SCALES.values())


def plain_unit(text: str) -> str:
    """Return a unit in the spelling of `SCALES`, `TIMES` and `FREQUENCIES`: ``Newtons`` is ``N``."""
    plain = text.strip()
    if plain in EXACT_SPELLINGS:
        return plain
    if plain.startswith("(") and plain.endswith(")"):
        plain = plain[1:-1].strip()
    for written, meant in SPELLINGS:
        plain = plain.replace(written, meant)
    plain = plain.replace(" ", "")
    return WORDS.get(plain.lower(), plain)


@dataclass(frozen=True)
class Calibration:
    """How the numbers of a file become a quantity in SI units.

    Attributes
    ----------
    quantity : str
        What was measured.
    scale : float
        SI value of one of the file's numbers; below zero where the sensor is turned round.
    """

    quantity: Quantity
    scale: float

    @property
    def unit(self) -> str:
        """SI unit."""
        return UNITS[self.quantity]


def calibration(file_unit: str, sensitivity: str | None, quantity: Quantity | None = None) -> Calibration:
    """Work out a channel's calibration.

    Parameters
    ----------
    file_unit : str
        Of the numbers in the file; ``FS`` of sound files, 1 for full scale.
    sensitivity : str or None
        What the sensor gives: ``100 mV/g``, ``0.2 FS/g``; None where the file holds the quantity itself.
    quantity : str, optional
        The quantity expected; needed where volts are meant as volts.

    Raises
    ------
    ValueError
        For units that are not known or do not fit each other, and for volts of a sensor without a sensitivity.
    """
    if sensitivity is None:
        if file_unit == "FS":
            raise ValueError('unit "FS" is no quantity; give sensitivity, for example "0.2 FS/g"')
        plain = unit(file_unit)
        if quantity is not None and plain.quantity != quantity:
            raise ValueError(
                f"{file_unit} is a unit of {plain.quantity}, not of {quantity}; give sensitivity, for example "
                f'"100 {file_unit}/{UNITS[quantity]}", or correct the unit'
            )
        if plain.quantity == "voltage" and quantity is None:
            raise ValueError(
                f'in {file_unit}, and no sensitivity; give sensitivity, for example "100 mV/g", or quantity = '
                '"voltage" where volts are meant'
            )
        return Calibration(plain.quantity, plain.scale)
    value, gives, per = _parts(sensitivity)
    if gives == file_unit == "FS":
        output = 1.0
    elif file_unit == "FS":
        raise ValueError(
            f"sensitivity {sensitivity!r} gives {gives}, but a sound file holds shares of full scale; with 10 V "
            'at full scale 100 mV/g are "0.01 FS/g"'
        )
    else:
        file, given = unit(file_unit), unit(gives)
        if file.quantity != given.quantity:
            raise ValueError(f"sensitivity {sensitivity!r} gives {gives}, but the file is in {file_unit}")
        output = file.scale / given.scale
    sensed = unit(per)
    if quantity is not None and sensed.quantity != quantity:
        raise ValueError(f"sensitivity {sensitivity!r} is of {sensed.quantity}, not of {quantity}")
    return Calibration(sensed.quantity, output * sensed.scale / value)


def _parts(sensitivity: str) -> tuple[float, str, str]:
    """Split ``100 mV/g`` into its number, what the sensor gives and what it senses."""
    found = SENSITIVITY.fullmatch(sensitivity)
    number = found[1] if found else ""
    if number.count(",") == 1 and "." not in number and len(number.partition(",")[2]) != 3:
        number = number.replace(",", ".")  # decimal; before three digits it may be a separator of thousands
    try:
        value = float(number)
    except ValueError:
        value = 0.0
    if found is None or value == 0.0 or abs(value) == float("inf"):
        raise ValueError(
            f'sensitivity {sensitivity!r}: a number other than 0 and a unit such as "100 mV/g" or "2.25 mV/N" is '
            "wanted, with a decimal point; a negative number turns the sensor round"
        )
    return value, found[2].strip(), found[3].strip()


def frf_name(response: Quantity, reference: Quantity) -> str:
    """Name an FRF after what it relates: ``accelerance``, ``mobility``, ``transmissibility``."""
    if response == reference:
        return "voltage ratio" if response == "voltage" else "transmissibility"
    return NAMES.get((response, reference), f"{response} per {reference}")


def frf_unit(response: Quantity, reference: Quantity) -> str:
    """SI unit of an FRF: ``m/s2/N``, ``V/V``."""
    return f"{UNITS[response]}/{UNITS[reference]}"


def frf_label(response: Quantity, reference: Quantity) -> str:
    """Axis label: ``accelerance [m/s2/N]``."""
    return f"{frf_name(response, reference)} [{frf_unit(response, reference)}]"
