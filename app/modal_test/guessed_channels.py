"""Roles, units and sample rate of a measurement's channels: as the user said, or guessed from their names."""

import re
from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.estimation.quantities import (
    FREQUENCIES,
    SCALES,
    TIMES,
    calibration,
    is_unit,
    plain_unit,
    unit,
    unit_behind_name,
)
from app.files.bad_file import ResultFileError
from app.files.declarations.modal_test import ENDS
from app.files.measurements.columns import Columns

GUESSES = (
    ("time", r"time|zeit|temps|^t$|^t[\s_/]+\(?([mun]?s|[mu]?sec)\)?$|x_value"),
    ("frequency", r"freq|^f$|^f[\s_/]+\(?(k?hz|rad.s)\)?$|^k?hz$"),
    ("drive", r"hammer|force|impact|kraft|shaker|drive|exc"),
    ("real", r"^re(al)?\b|real"),
    ("imaginary", r"^im(ag.*)?\b|imag"),
    ("magnitude", r"^mag(nitude)?\b|^abs\b|betrag"),
    ("phase", r"^phase?\b|^arg\b|^angle\b"),
    ("coherence", r"coh"),
)
"""Roles by what channels are commonly called; all else is a response."""

SPECTRA = r"spec|corr|psd|csd|(?<![a-z])[gs](xy|yx)(?![a-z])|^[gs]\d+(_\d+)?$"
"""What complex values are called that are no FRFs, if the file also has some of another name."""

RATE_NAMES = r"(?<![a-z])fs(?![a-z])|rate(?![a-z])|sampling|abtast"
"""What a file may call its sample rate: ``fs``, ``test.Fs``, ``sampleRate``; not ``offset``."""


@dataclass(frozen=True)
class NewTest:
    """What a user said of a test.

    Attributes
    ----------
    kind : str or None
        None to be guessed.
    drives, responses : dict of str to str or None
        Sensitivity or unit by channel, or by a pattern with *; None where the file gives the unit.
    unused : tuple of str
    title : str
    sample_rate : float or None
        Hz.
    roving : str or None
        Channel that is at node 1 in the first file, at 2 in the second; of files with one FRF ``response`` or
        ``reference``.
    same_point : bool
        Whether all files are of the same points, whatever they are called.
    points : Path or None
        Table of nodes with their places.
    frf_units : (str, str) or None
        Of FRFs, response and reference.
    """

    kind: str | None
    drives: dict[str, str | None]
    responses: dict[str, str | None]
    unused: Sequence[str] = ()
    title: str = ""
    sample_rate: float | None = None
    roving: str | None = None
    points: Path | None = None
    frf_units: tuple[str, str] | None = None
    same_point: bool = False


def of_unnamed(columns: Columns, taken: AbstractSet[str], kind: str | None) -> dict[str, dict[str, Any]]:
    """Return the roles that only order and values tell: the axis, and the parts of one FRF.

    Parameters
    ----------
    taken : set of str
        Columns that the user named.
    kind : str or None
        Of the test, as far as it is said.

    Returns
    -------
    dict of str to dict
        Of the columns that tell; empty where the columns have names.

    Raises
    ------
    ValueError
        Where the two parts of an FRF may be real and imaginary, or magnitude and phase.
    """
    names = list(columns.values)
    base = names[0].removesuffix("1]") + "{}]" if names[0].endswith("[1]") else "{}"
    numbered = names == [base.format(number) for number in range(1, len(names) + 1)]
    first = columns.values[names[0]]
    step = np.diff(first.real)
    one_way = len(step) > 1 and bool((step > 0.0).all() or (step < 0.0).all())  # sines are stepped up or down
    even = one_way and bool(np.ptp(step) < 0.1 * np.median(step))
    leads = names[0] == "1" or (numbered and even)
    if not leads or names[0] in taken or columns.rates or not (one_way if kind == "frf" else even):
        return {}
    if kind != "frf":
        return {names[0]: {"role": "time"}} if not np.iscomplexobj(first) else {}
    roles = _parts_of_frf(columns, names) if numbered and len(names) == 3 else []
    return {name: {"role": role} for name, role in zip(names, ["frequency", *roles], strict=False)}


FULL_TURNS = (np.pi, 2.0 * np.pi, 180.0, 360.0)
"""Where phases end that are wrapped, in radians and in degrees."""
LARGEST_PART_RATIO = 3.0
"""Ratio of the sizes of two parts up to which a number that could be a phase could be an imaginary part, too."""


def _parts_of_frf(columns: Columns, names: Sequence[str]) -> list[str]:
    """Roles of two columns without names: real and imaginary, or magnitude and phase; ValueError if both may be.

    A magnitude is nowhere negative, or in decibels; a phase ends near a half or a whole turn, or jumps by one.
    """
    one, other = (columns.values[name].real for name in names[1:])
    usual = [part[np.isfinite(part)] for part in (one, other)]
    if any(len(part) < 3 for part in usual):
        return ["real", "imaginary"]
    size, reach = float(np.abs(usual[0]).max()), float(np.abs(usual[1]).max())
    jumps = float(np.abs(np.diff(usual[1])).max())
    ends = any(0.9 * turn <= reach <= 1.01 * turn for turn in FULL_TURNS)
    wrapped = any(0.95 * turn <= jumps <= 1.05 * turn for turn in FULL_TURNS[1::2])
    positive = bool((usual[0] >= 0.0).all())
    within = reach <= 1.01 * FULL_TURNS[3]
    if not positive and not (within and (ends or wrapped)):
        return ["real", "imaginary"]
    if not within or reach < 0.5:  # no phase of a resonance turns by less than half a radian
        return ["real", "imaginary"]
    if positive and (ends or wrapped or not 1.0 / LARGEST_PART_RATIO < reach / (0.5 * size) < LARGEST_PART_RATIO):
        return ["magnitude", "phase"]
    raise ValueError(
        "columns 2 and 3 without names may be real and imaginary part, or magnitude and phase; write their names "
        'into the first line: "Frequency,Real,Imaginary" or "Frequency,Magnitude,Phase"'
    )


def guessed_channels(file: Path, columns: Columns, said: NewTest) -> dict[str, dict[str, Any]]:
    """Return role, unit and sensitivity of every column, by its name, as a declaration holds them.

    Parameters
    ----------
    file : Path
        Measurement the columns were read from, for messages.

    Raises
    ------
    ResultFileError
        For a channel named by the user that the file does not hold, and what is neither unit nor sensitivity.
    """
    roving = [said.roving] if said.roving and said.roving not in ENDS else []
    said = _by_names_of_file(said, columns)
    named = [*said.drives, *said.responses, *said.unused, *roving]
    strangers = [name for name in named if not any(_means(name, one) for one in columns.values)]
    if strangers:
        there = ", ".join(list(columns.values)[:20])
        raise ResultFileError(f"{file}: no channel {strangers[0]!r}; it holds: {there}")
    try:
        channels = {name: _channel(name, columns, said) for name in columns.values} | of_unnamed(
            columns, {*said.drives, *said.responses, *said.unused}, said.kind
        )
        return _without_strangers(channels, columns, said)
    except ValueError as error:
        raise ResultFileError(f"{file}: {error}") from error


def _by_names_of_file(said: NewTest, columns: Columns) -> NewTest:
    """Return what was said with the file's names of channels that the user knows by their place."""

    def known(name: str) -> str:
        return columns.aliases.get(name, name) if name not in columns.values else name

    drives, responses = (
        {known(name): given for name, given in one.items()} for one in (said.drives, said.responses)
    )
    return replace(said, drives=drives, responses=responses, unused=[known(name) for name in said.unused])


def _without_strangers(
    channels: dict[str, dict[str, Any]], columns: Columns, said: NewTest
) -> dict[str, dict[str, Any]]:
    """Return the channels with those unused that nobody named and that cannot belong to the test.

    Of several columns of frequencies the first one stays. Responses of another rate or length than the drive,
    and in units of temperature and the like, are logged beside the test.
    """
    lines = [name for name, one in channels.items() if one["role"] == "frequency"]
    drives = [name for name, one in channels.items() if one["role"] == "drive"]
    unused = set(lines[1:])
    for name, one in channels.items():
        if one["role"] != "response" or not drives or any(_means(pattern, name) for pattern in said.responses):
            continue
        other = columns.values[name].shape != columns.values[drives[0]].shape
        mine, theirs = columns.rates.get(name), columns.rates.get(drives[0])
        slower = bool(mine and theirs and abs(mine / theirs - 1.0) > 1e-3)
        if other or slower or plain_unit(columns.units.get(name, "")) in BESIDE:
            unused.add(name)
    if all(name in unused for name, one in channels.items() if one["role"] == "response"):
        unused = set(lines[1:])  # then identify says how they differ from the drive
    return {name: {"role": "unused"} if name in unused else one for name, one in channels.items()}


BESIDE = frozenset(
    {
        "°C",
        "degC",
        "C°",
        "DegC",
        "℃",
        "K",
        "°F",
        "degF",
        "DegF",
        "%",
        "%RH",
        "rpm",
        "RPM",
        "1/min",
        "A",
        "mA",
        "Ohm",
    }
)
"""Units of what is logged beside a test: temperature, humidity, speed, current."""


def guessed_frf_units(columns: Columns, channels: Mapping[str, Mapping[str, Any]]) -> tuple[str, str] | None:
    """Return the units of response and reference that the file gives with its FRFs, ``g/N``, if it does."""
    for name, channel in channels.items():
        if channel["role"] in ("frf", "real"):
            response, _, reference = columns.units.get(name, "").rpartition("/")
            pair = response.strip("() "), reference.strip("() ")
            if is_unit(pair[0]) and is_unit(pair[1]):
                return pair
    return None


def guessed_rate(columns: Columns, said: NewTest, roles: Sequence[str]) -> dict[str, Any]:
    """Return the sample rate as said, or the file's own number that is called so, where nothing else gives it.

    Parameters
    ----------
    roles : sequence of str
        Of all channels.

    Returns
    -------
    dict
        ``sample_rate``, Hz or the name of the file's number; empty where the file gives it, or if it is unknown.
    """
    if said.sample_rate is not None:
        return {"sample_rate": said.sample_rate}
    if "time" in roles or "frequency" in roles or columns.rates:
        return {}
    named = [name for name in columns.scalars if re.search(RATE_NAMES, name, re.IGNORECASE)]
    return {"sample_rate": named[0]} if named else {}


def lacking_calibration(channel: Mapping[str, Any], file_unit: str | None) -> str:
    """Return what a drive or response lacks to become a quantity; empty where nothing lacks."""
    if channel["role"] not in ("drive", "response") or channel.get("sensitivity"):
        return ""
    written = str(channel.get("unit") or file_unit)
    if written == "FS":
        return 'is in shares of full scale: give its sensitivity, for example "0.2 FS/g"'
    try:
        volts = unit(written).quantity == "voltage"
    except ValueError:
        return f'has the unit {written!r}, which is not known: give unit, for example "m/s2"'
    if not volts:
        return ""
    if file_unit is None:
        return 'has no unit in the file, and volts are assumed: give its unit, or its sensitivity, as "100 mV/g"'
    return 'is in volts: give its sensitivity, for example "100 mV/g"'


def _channel(name: str, columns: Columns, said: NewTest) -> dict[str, Any]:
    """Role, unit and sensitivity of one column, said or guessed."""
    file_unit = columns.units.get(name)
    for role, named in (("drive", said.drives), ("response", said.responses)):
        meant = [pattern for pattern in named if _means(pattern, name)]
        if meant:
            given = named[name if name in meant else meant[0]]
            return {"role": role} | _unit_or_sensitivity(name, given, file_unit)
    if any(_means(pattern, name) for pattern in said.unused):
        return {"role": "unused"}
    if np.iscomplexobj(columns.values[name]):
        others = [one for one in columns.values if np.iscomplexobj(columns.values[one]) and not _spectrum(one)]
        return {"role": "unused" if others and _spectrum(name) else "frf"}
    role = next((role for role, words in GUESSES if re.search(words, name.strip(), re.IGNORECASE)), "response")
    written = plain_unit(file_unit or "")
    beside_frfs = any(np.iscomplexobj(values) for values in columns.values.values())
    if role == "response" and beside_frfs and unit_behind_name(name, FREQUENCIES):
        role = "frequency"  # omega
    if written in TIMES:
        role = "time"
    elif written in ("Hz", "kHz"):
        role = "frequency"
    elif written in SCALES["force"]:
        role = "drive"
    if role in ("magnitude", "phase") and not _has_both(columns):
        role = "response"
    if (role == "drive" and said.drives) or (
        role == "response" and not file_unit and _counts(columns.values[name])
    ):
        role = "unused"
    channel = {"role": role}
    if role in ("drive", "response") and not file_unit:
        channel["unit"] = "V"
    return channel


def _has_both(columns: Columns) -> bool:
    """Whether one magnitude and one phase are among the columns, so that neither is a name of a signal."""
    called = [name.strip() for name in columns.values]
    roles = [role for role, words in GUESSES for name in called if re.search(words, name, re.IGNORECASE)]
    return roles.count("magnitude") == roles.count("phase") == 1


def _spectrum(name: str) -> bool:
    return re.search(SPECTRA, name, re.IGNORECASE) is not None


def _counts(values: NDArray[Any]) -> bool:
    """Whether a column numbers the samples."""
    return len(values) > 2 and bool((np.diff(values) == 1.0).all())


def _means(pattern: str, name: str) -> bool:
    """Whether a user's word is that name, or a pattern with * that it fits."""
    return pattern == name or (
        "*" in pattern and re.fullmatch(re.escape(pattern).replace(r"\*", ".*"), name) is not None
    )


def _unit_or_sensitivity(name: str, given: str | None, file_unit: str | None) -> dict[str, str]:
    """Keys of a channel for what a user wrote behind its name: ``m/s2``, ``100 mV/g``, or nothing."""
    if given is None:
        return {} if file_unit else {"unit": "V"}
    try:
        unit(given)
    except ValueError as error:
        if not any(sign.isdigit() for sign in given.partition("/")[0]):
            raise ValueError(f"{name}={given}: {error}, or a sensitivity such as 100 mV/g") from error
        try:
            calibration(file_unit or "V", given)
        except ValueError as wrong:
            raise ValueError(f"{name}={given}: {wrong}") from wrong
        return {"sensitivity": given} | ({} if file_unit else {"unit": "V"})
    return {"unit": given}
