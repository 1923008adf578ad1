"""A declaration to start from: of a test, after a look into its files, or of a campaign, after the shipped one."""

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from analysis.estimation.quantities import unit
from app.files.atomic import write_text
from app.files.bad_file import ResultFileError
from app.files.campaign_toml import NAME as CAMPAIGN_NAME
from app.files.measurements.columns import Columns
from app.files.measurements.guarded import read_columns
from app.files.modal_test_toml import ENDS, FORMAT, ModalTest
from app.files.settings_toml import checked, read_table
from app.files.shipped import shipped
from app.files.toml_text import toml_text
from app.modal_test.points_table import points_of_table

GUESSES = (
    ("time", r"time|zeit|temps|^t$|x_value"),
    ("frequency", r"freq|^f$|^hz$"),
    ("drive", r"hammer|force|impact|kraft|shaker|drive|exc"),
    ("real", r"^re(al)?\b|real"),
    ("imaginary", r"^im(ag.*)?\b|imag"),
    ("coherence", r"coh"),
)
"""Roles by what channels are commonly called; all else is a response."""

RATE_NAMES = r"(?<![a-z])fs(?![a-z])|rate(?![a-z])|sampling|abtast"
"""What a file may call its sample rate: ``fs``, ``test.Fs``, ``sampleRate``; not ``offset``."""

TEST_HEAD = """What this test is; see the guide, "A modal test". Correct what was guessed:
role: drive, response, time, frequency, frf, real, imaginary, coherence, unused
sensitivity: what the sensor gives, "100 mV/g" or "2.25 mV/N"; left out where the file holds the unit itself
at: node and direction, "5:+z"; [points] gives nodes their places in metres"""

CAMPAIGN_HEAD = """A recorded campaign, after the example that comes with Flexura: replace its numbers by yours
(guide, "A recorded campaign"), and put one TDMS file for each temperature into sweeps/."""


@dataclass(frozen=True)
class NewTest:
    """What a user said of a test.

    Attributes
    ----------
    kind : str or None
        None to be guessed.
    drives, responses : dict of str to str or None
        Sensitivity or unit by channel, or by a pattern with *; None where the file tells the unit.
    unused : tuple of str
    title : str
    sample_rate : float or None
        Hz.
    roving : str or None
        Channel that is at node 1 in the first file, at 2 in the second; of files with one FRF ``response`` or
        ``reference``.
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


def new_test(files: Sequence[Path], said: NewTest, target: Path) -> tuple[ModalTest, list[str]]:
    """Write a test's declaration.

    Parameters
    ----------
    files : sequence of Path
        Measurements; the first is looked into.
    said : NewTest
    target : Path
        File to write.

    Returns
    -------
    declared : ModalTest
    missing : list of str
        Channels in volts without a sensitivity, to be completed by hand.

    Raises
    ------
    ResultFileError
        For files that cannot be read, and channels named that are not there.
    CampaignFileError
        Where what was said and guessed makes no test.
    """
    if not files:
        raise ResultFileError("no file named; type: flexura new test FILE ...")
    columns = read_columns(files[0])
    named = [
        *said.drives,
        *said.responses,
        *said.unused,
        *([said.roving] if said.roving and said.roving not in ENDS else []),
    ]
    strangers = [name for name in named if not any(_means(name, one) for one in columns.values)]
    if strangers:
        there = ", ".join(list(columns.values)[:20])
        raise ResultFileError(f"{files[0]}: no channel {strangers[0]!r}; it holds: {there}")
    channels = {name: _channel(name, columns, said) for name in columns.values}
    roles = [str(channel["role"]) for channel in channels.values()]
    kind = said.kind or ("frf" if "frequency" in roles else "hammer")
    if kind != "frf" and "drive" not in roles:
        raise ResultFileError(
            f"{files[0]}: none of its channels is called like a drive; name it with --drive NAME=SENSITIVITY. It "
            f"holds: {', '.join(list(columns.values)[:20])}"
        )
    nodes = 0
    for channel in channels.values():
        if channel["role"] in ("response", "frf"):
            nodes += 1
            channel["at"] = f"{nodes}:+z"
        elif channel["role"] == "drive":
            channel["at"] = "1:+z"
    table: dict[str, Any] = {"format": FORMAT, "title": said.title or target.resolve().parent.name, "kind": kind}
    table |= _rate(columns, said, roles) | {"channels": channels}
    if kind == "hammer":
        table["hammer"] = {"pretrigger": 0.005, "exponential": 1.0}
    elif kind == "continuous":
        table["segments"] = {"seconds": 2.0, "window": "hann", "overlap": 0.5}
    else:
        table["frf"] = dict(zip(("response", "reference"), said.frf_units or ("m/s2", "N"), strict=True))
    folder = target.resolve().parent
    table["record"] = [
        {"file": Path(os.path.relpath(file.resolve(), folder)).as_posix()}
        | ({"at": {said.roving: f"{number}:+z"}} if said.roving else {})
        for number, file in enumerate(files, start=1)
    ]
    if said.points is not None:
        table["points"] = points_of_table(said.points)
    declared = checked(target, table, ModalTest)
    _write(target, toml_text(table, TEST_HEAD))
    return declared, [name for name, one in channels.items() if _lacks_sensitivity(one, columns.units.get(name))]


def _rate(columns: Columns, said: NewTest, roles: Sequence[str]) -> dict[str, Any]:
    """Sample rate as said, or the file's own number that is called so, where nothing else tells it."""
    if said.sample_rate is not None:
        return {"sample_rate": said.sample_rate}
    if "time" in roles or "frequency" in roles or columns.rates:
        return {}
    named = [name for name in columns.scalars if re.search(RATE_NAMES, name, re.IGNORECASE)]
    return {"sample_rate": named[0]} if named else {}


def _channel(name: str, columns: Columns, said: NewTest) -> dict[str, Any]:
    """Role, unit and sensitivity of one column, said or guessed."""
    file_unit = columns.units.get(name)
    for role, named in (("drive", said.drives), ("response", said.responses)):
        meant = [pattern for pattern in named if _means(pattern, name)]
        if meant:
            told = named[name if name in meant else meant[0]]
            return {"role": role} | _unit_or_sensitivity(told, file_unit)
    if any(_means(pattern, name) for pattern in said.unused):
        return {"role": "unused"}
    if np.iscomplexobj(columns.values[name]):
        return {"role": "frf"}
    role = next((role for role, words in GUESSES if re.search(words, name.strip(), re.IGNORECASE)), "response")
    if file_unit in ("s", "sec"):
        role = "time"
    elif file_unit == "Hz":
        role = "frequency"
    elif file_unit in ("N", "kN", "lbf"):
        role = "drive"
    if role == "drive" and said.drives:
        role = "unused"
    channel = {"role": role}
    if role in ("drive", "response") and not file_unit:
        channel["unit"] = "V"
    return channel


def _means(pattern: str, name: str) -> bool:
    """Whether a user's word is that name, or a pattern with * that it fits."""
    return pattern == name or (
        "*" in pattern and re.fullmatch(re.escape(pattern).replace(r"\*", ".*"), name) is not None
    )


def _unit_or_sensitivity(told: str | None, file_unit: str | None) -> dict[str, str]:
    """Keys of a channel for what a user wrote behind its name: ``m/s2``, ``100 mV/g``, or nothing."""
    if told is None:
        return {} if file_unit else {"unit": "V"}
    try:
        unit(told)
    except ValueError:
        return {"sensitivity": told} | ({} if file_unit else {"unit": "V"})
    return {"unit": told}


def _lacks_sensitivity(channel: Mapping[str, Any], file_unit: str | None) -> bool:
    if channel["role"] not in ("drive", "response") or channel.get("sensitivity"):
        return False
    try:
        return unit(str(channel.get("unit") or file_unit)).quantity == "voltage"
    except ValueError:  # FS, or a unit that nobody knows
        return True


def new_campaign(target: Path, plate: tuple[float, float, float, float] | None, title: str) -> Path:
    """Write ``campaign.toml`` into the folder `target`, or as the file of that name.

    Parameters
    ----------
    target : Path
    plate : (float, float, float, float) or None
        Length along x and y, thickness, m, and mass, kg; None for those of the example.
    title : str
        Empty for that of the folder.

    Returns
    -------
    Path
        Of the file.

    Raises
    ------
    ResultFileError
        Where there is a declaration already.
    """
    file = target if target.suffix == ".toml" else target / CAMPAIGN_NAME
    if file.exists():
        raise ResultFileError(f"{file}: is there already; name another with --out, or remove it")
    table = read_table(shipped("pp-plate") / CAMPAIGN_NAME)
    table["title"] = title or file.resolve().parent.name
    if plate is not None:
        table["plate"] |= dict(zip(("length_x", "length_y", "thickness", "mass"), plate, strict=True))
    _write(file, toml_text(table, CAMPAIGN_HEAD))
    return file


def _write(target: Path, text: str) -> None:
    try:
        write_text(target, text)
    except OSError as error:
        raise ResultFileError(
            f"{target}: cannot be written ({error.strerror}); name another with --out"
        ) from error
