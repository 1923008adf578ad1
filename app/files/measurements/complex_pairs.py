"""FRFs written as two columns each, real and imaginary part or magnitude and phase, made complex."""

import re
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.estimation.quantities import FREQUENCIES, plain_unit
from app.files.measurements.columns import Columns, unused_name

FREQUENCY = re.compile(r"freq|^f([\s_/]+\(?(k?hz|rad.s)\)?)?$|^k?hz$", re.IGNORECASE)
PARTS = {
    "real": r"re(?:al)?",
    "imaginary": r"im(?:ag(?:inary|inär)?)?",
    "magnitude": r"mag(?:nitude)?|abs|ampl?(?:itude)?|betrag",
    "phase": r"ph(?:ase|i)?|arg|angle",
}
"""What the parts of an FRF are called, as words of their own."""
PLACE = re.compile(r"\[\d+(?:,\d+)*\]$")
WORD = r"(?<![a-zA-Z])(?:{})(?![a-zA-Z])(?:[ _-]*part)?"
KINDS = (("real", "imaginary"), ("magnitude", "phase"))
TURN = 6.4
"""Largest phase up to which one without a unit is in radians: an FRF's covers more than 6 degrees."""


def with_complex_pairs(columns: Columns) -> Columns:
    """Return the columns with each magnitude and phase, and of several FRFs each real and imaginary part, as one.

    Parameters
    ----------
    columns : Columns

    Returns
    -------
    Columns
        Unchanged where no column holds frequencies. A single pair of real and imaginary part stays: it has its own
        roles in a declaration.
    """
    if columns.channels or not any(_is_frequency(name, columns) for name in columns.values):
        return columns
    found = [pair for kind in KINDS for pair in _pairs(kind, columns)]
    if len(found) == 1 and found[0][0] == "real":
        return columns
    values = dict(columns.values)
    for _, base, first, second in found:
        h, unit = _joined(columns, first, second)
        del values[first], values[second]
        name = unused_name(base or "FRF", values)
        values[name] = h
        columns.units.pop(first, None)
        if unit:
            columns.units[name] = unit
    return replace(columns, values=values)


def _is_frequency(name: str, columns: Columns) -> bool:
    return bool(FREQUENCY.search(name.strip())) or plain_unit(columns.units.get(name, "")) in FREQUENCIES


def _pairs(kind: tuple[str, str], columns: Columns) -> list[tuple[str, str, str, str]]:
    """Kind, common name and the two columns of every pair of one kind."""
    named: list[dict[str, str]] = []
    for part in kind:
        word = re.compile(WORD.format(PARTS[part]), re.IGNORECASE)
        bases = {name: word.sub(" ", name, count=1) for name in columns.values if word.search(name)}
        named.append({_base(base): name for name, base in bases.items()})
    return [(kind[0], base, name, named[1][base]) for base, name in named[0].items() if base in named[1]]


def _base(name: str) -> str:
    """Return a name without the signs around the part's word; the place in an array, ``[1,2]``, stays as it is."""
    place = PLACE.search(name)
    stem = name[: place.start()] if place else name
    return " ".join(re.split(r"[\s_:,.-]+", stem)).strip(" ()|/") + (place[0] if place else "")


def _joined(columns: Columns, first: str, second: str) -> tuple[NDArray[Any], str]:
    """Complex values of a pair, and their unit."""
    one, other = columns.values[first].real, columns.values[second].real
    unit, turned = columns.units.get(first, ""), columns.units.get(second, "")
    if len(one) != len(other):
        raise ValueError(f"{first!r} has {len(one)} values, {second!r} {len(other)}; export both alike")
    if not re.search(WORD.format(PARTS["phase"]), second, re.IGNORECASE):
        return one + 1j * other, unit
    return of_magnitude_and_phase(one, other, unit, turned)


def of_magnitude_and_phase(
    one: NDArray[np.float64], other: NDArray[np.float64], unit: str, turned: str
) -> tuple[NDArray[np.complex128], str]:
    """Complex values of a magnitude and a phase.

    Parameters
    ----------
    one : (F,) ndarray
        Magnitude; in decibels if its unit says so, or some values are below zero.
    other : (F,) ndarray
        Phase; in radians if its unit says so, or none is larger than a turn and no unit is given.
    unit, turned : str
        As the file writes them; may be empty.

    Returns
    -------
    h : (F,) complex ndarray
    unit : str
        Of the magnitude, without decibels.
    """
    decibels = unit.lower().startswith("db") or bool((one < 0.0).any())
    with np.errstate(over="ignore", invalid="ignore"):  # not finite at 0 Hz, or refused where the FRF is checked
        magnitude = np.power(10.0, one / 20.0) if decibels else one
        largest = float(np.abs(other[np.isfinite(other)]).max(initial=0.0))
        radians = turned.lower().startswith("rad") or (not turned and largest < TURN)
        turn: NDArray[np.complex128] = np.exp(1j * (other if radians else np.radians(other)))
    unit = re.sub(r"^db\s*(re|ref|\()?\s*1?\s*", "", unit, flags=re.IGNORECASE).rstrip(")") if decibels else unit
    return magnitude * turn, unit
