"""A declaration to start from: of a test, after a look into its files and a table of places; of a campaign.

Guessed for it are the kind of the test and its segments, from the roles of its channels and the course of its
drive, and nodes and directions of channels, as the file gives them, or numbered.
"""

import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.estimation.quantities import SCALES, unit
from analysis.estimation.spectra import SampledSignals, fitting_segments, is_impacts
from app.files.atomic import write_text
from app.files.bad_file import ResultFileError
from app.files.campaigns.kind import DECLARATION
from app.files.campaigns.recorded import SWEEPS
from app.files.declarations.modal_test import FORMAT, NAME, ModalTest
from app.files.measurements.columns import Columns
from app.files.measurements.guarded import read_columns, read_each
from app.files.settings_toml import checked, read_table, toml_text
from app.files.shipped import shipped
from app.modal_test.guessed_channels import (
    NewTest,
    guessed_channels,
    guessed_frf_units,
    guessed_rate,
    lacking_calibration,
)
from app.modal_test.signals import sample_rate

TEST_HEAD = """What this test is; see the guide, "A modal test". Correct what was guessed:
role: drive, response, time, frequency, frf, real, imaginary, magnitude, phase, coherence, unused
sensitivity: what the sensor gives, "100 mV/g" or "2.25 mV/N"; left out where the file holds the unit itself
at: node and direction, "5:+z"; [points] gives nodes their places in metres"""
CAMPAIGN_HEAD = """A recorded campaign, after the example that comes with Flexura: replace its numbers by yours
(guide, "A recorded campaign"), and put one TDMS file for each temperature into sweeps/."""


class PlacesUnknownError(ResultFileError):
    """Files are called after points, and nothing says which channel was moved from one to the next.

    Attributes
    ----------
    channels : tuple of str
        Those that may have been.
    """

    def __init__(self, files: Sequence[Path], channels: tuple[str, ...]) -> None:
        first, last = files[0].name, files[-1].name
        super().__init__(
            f"{first} to {last} are called after points: name the channel that was moved from one to the next, "
            f"--roving {channels[0]} (one of {', '.join(channels)}), or say --same-point"
        )
        self.channels = channels


SEGMENT_SECONDS = 2.0
"""Of a segment; lines lie 0.5 Hz apart."""


def guessed_kind(columns: Columns, channels: Mapping[str, Mapping[str, Any]], said: NewTest) -> str:
    """Return the kind of test.

    Parameters
    ----------
    channels : mapping
        Role of each column.

    Returns
    -------
    str
        As said; ``frf`` where there are frequencies and FRFs; else ``hammer`` where the drive acts in blows, and
        ``continuous`` where it does not.
    """
    roles = {channel["role"] for channel in channels.values()}
    frfs = "frf" in roles or {"real", "imaginary"} <= roles or {"magnitude", "phase"} <= roles
    if said.kind or ("frequency" in roles and frfs):
        return said.kind or "frf"
    drives = _signals(columns, [name for name, one in channels.items() if one["role"] == "drive"])
    return "hammer" if drives is None or all(map(is_impacts, drives)) else "continuous"


def guessed_segments(file: str, columns: Columns, test: ModalTest) -> dict[str, Any]:
    """Return the segments of a continuous test: a whole period or sweep, or else Hann's of `SEGMENT_SECONDS`.

    Parameters
    ----------
    file : str
        Its name.
    test : ModalTest
        Says what each column is.

    Returns
    -------
    dict
        ``seconds``, ``window``, ``overlap``.
    """
    seconds, window, overlap = SEGMENT_SECONDS, "hann", 0.5
    drives = _signals(columns, [name for name, one in test.channels.items() if one.role == "drive"])
    if drives is not None:
        try:
            recording = SampledSignals(sample_rate(file, columns, test)[0], drives, drives)
        except ValueError:  # said when the test is identified
            pass
        else:
            seconds, window, overlap = fitting_segments(recording, SEGMENT_SECONDS)
    return {"seconds": seconds, "window": window, "overlap": overlap}


def _signals(columns: Columns, names: Sequence[str]) -> NDArray[np.float64] | None:
    """Signals of channels, (M, N); None where they cannot be compared."""
    signals = [columns.values[name].real for name in names if name in columns.values]
    if len({len(one) for one in signals}) != 1:
        return None
    return np.array(signals) if all(np.isfinite(one).all() and np.ptp(one) > 0.0 for one in signals) else None


OF_MATRIX = re.compile(r".*\[([1-9]\d*),([1-9]\d*)\]")
"""``H[3,2]``, response and reference of an FRF in an array of three axes."""
NUMBERED = re.compile(r"([a-z]*)[ _-]*(\d+)", re.I)
"""A number in the name of a file, and the word before it: ``hammer_p12_hit3`` has two."""
OF_POINT = re.compile(r"points?|pts?|p|nodes?|n|mp|pos(?:ition)?|dof|loc(?:ation)?|place", re.I)
"""Words before a number that says where: ``point3``, ``hammer_p12``."""
OF_REPEAT = re.compile(
    r"hits?|blows?|impacts?|strikes?|h|runs?|r|rep(?:eat)?s?|avg|averages?|trials?|shots?|takes?|meas(?:urement)?",
    re.I,
)
"""Words before a number that says when: ``hit3``, ``run3``."""


def _numbers(files: Sequence[Path]) -> list[tuple[str, list[int]]]:
    """Numbers that differ between names of files, with the word before them; none where words differ."""
    found = [NUMBERED.findall(file.name.partition(".")[0]) for file in files]
    if len({tuple(word.lower() for word, _ in one) for one in found}) != 1:
        return []
    columns = [(one[0][0], [int(number) for _, number in one]) for one in zip(*found, strict=True)]
    return [(word, numbers) for word, numbers in columns if len(set(numbers)) > 1]


def _points(files: Sequence[Path]) -> list[int] | None:
    """Numbers of the points after which files are called; None where their names do not say where."""
    points = [numbers for word, numbers in _numbers(files) if OF_POINT.fullmatch(word)]
    return points[0] if len(points) == 1 else None


def of_points(files: Sequence[Path]) -> bool:
    """Whether the names of several files say at which points they were measured."""
    return _points(files) is not None


def roved_nodes(files: Sequence[Path]) -> list[int]:
    """Node of each file of a channel that was moved: that of its name, or else its place among the files.

    ``point10`` is node 10, though a shell lists it before ``point2``; ``p2_hit1`` and ``p2_hit2`` are both of node
    2. A number that does not say of what (``rec001``) only orders the files, if no other order was given.

    Parameters
    ----------
    files : sequence of Path
        As they were named.

    Returns
    -------
    list of int
        From 1.
    """
    points, numbers = _points(files), _numbers(files)
    if points is not None and min(points) > 0:
        return points
    others = [one for word, one in numbers if not OF_REPEAT.fullmatch(word)]
    by = points
    if by is None and len(others) == 1 and len(numbers) > 1:
        by = others[0]
    elif by is None and len(numbers) == 1 and list(files) == sorted(files):
        by = numbers[0][1]
    if by is None:
        return list(range(1, len(files) + 1))
    ranks = {number: rank for rank, number in enumerate(sorted(set(by)), start=1)}
    return [ranks[number] for number in by]


def guessed_places(channels: Mapping[str, Mapping[str, Any]], columns: Columns) -> dict[str, dict[str, Any]]:
    """Return the channels with ``at``, and FRFs of an array of three axes with ``reference``.

    Parameters
    ----------
    channels : mapping
        Role of each column, and more.

    Returns
    -------
    dict of str to dict
        Places are those of the file; without them responses are numbered from 1, and so are drives.
    """
    taken = set(columns.places.values())
    free = [f"{node}:+z" for node in range(1, len(channels) + len(taken) + 1)]
    free = [place for place in free if place not in taken]
    placed = {name: dict(channel) for name, channel in channels.items()}
    for roles in (("response", "frf"), ("drive",)):
        nodes = iter(free)
        for name, channel in placed.items():
            if channel["role"] not in roles:
                continue
            channel["at"] = columns.places.get(name) or next(nodes)
            if channel["role"] == "frf" and name in columns.references:
                channel["reference"] = columns.references[name]
            if channel["role"] == "frf" and (found := OF_MATRIX.fullmatch(name)):
                channel["at"], channel["reference"] = (f"{node}:+z" for node in found.groups())
    return placed


def new_test(files: Sequence[Path], said: NewTest, target: Path) -> tuple[ModalTest, dict[str, str]]:
    """Write a test's declaration.

    Parameters
    ----------
    files : sequence of Path
        Measurements; the first is looked into.
    target : Path
        File to write.

    Returns
    -------
    declared : ModalTest
    missing : dict of str to str
        What channels lack, by their names, to be completed by hand.

    Raises
    ------
    ResultFileError
        For files that cannot be read, and channels named that are not there.
    PlacesUnknownError
        For files called after points, where nothing says what was moved.
    CampaignFileError
        Where what was said and guessed makes no test.
    """
    if not files:
        raise ResultFileError("no file named; type: flexura new test FILE ...")
    columns = read_columns(files[0])
    groups = columns.groups
    if groups:
        columns = columns.of_group(groups[0])
    channels = guessed_channels(files[0], columns, said)
    kind = guessed_kind(columns, channels, said)
    if kind == "frf":
        unused = {
            name: {"role": "unused"} for name, one in channels.items() if one["role"] in ("drive", "response")
        }
        channels |= unused
    roles = [str(channel["role"]) for channel in channels.values()]
    if kind != "frf" and "drive" not in roles:
        frfs = "; of FRFs export complex values, or real and imaginary parts" if "frequency" in roles else ""
        raise ResultFileError(
            f"{files[0]}: none of its channels is called like a drive; name it with --drive NAME=SENSITIVITY. It "
            f"holds: {', '.join(list(columns.values)[:20])}{frfs}"
        )
    if not groups:
        _require_places(files, columns, channels, kind, said)
    channels = guessed_places(channels, columns)
    table: dict[str, Any] = {"format": FORMAT, "title": said.title or _called(target), "kind": kind}
    table |= guessed_rate(columns, said, roles) | {"channels": channels}
    if kind == "hammer":
        table["hammer"] = {"exponential": 1.0}
    elif kind == "frf":
        table["frf"] = dict(
            zip(
                ("response", "reference"),
                said.frf_units or guessed_frf_units(columns, channels) or ("m/s2", "N"),
                strict=True,
            )
        )
    folder = target.resolve().parent
    of_files: list[Sequence[str]] = _groups(files, groups) if groups else [("",)] * len(files)
    nodes = roved_nodes(files) if said.roving else [0] * len(files)
    table["record"] = [
        {"file": Path(os.path.relpath(file.resolve(), folder)).as_posix()}
        | ({"group": group} if group else {})
        | ({"at": {said.roving: f"{node}:+z"}} if said.roving else {})
        for file, held, node in zip(files, of_files, nodes, strict=True)
        for group in held
    ]
    if said.points is not None:
        table["points"] = points_of_table(said.points)
    if kind == "continuous":
        test = checked(target, table, ModalTest)
        table["segments"] = guessed_segments(files[0].name, columns, test)
    declared = checked(target, table, ModalTest)
    write_text(target, toml_text(table, TEST_HEAD))
    missing = {name: lacking_calibration(one, columns.units.get(name)) for name, one in channels.items()}
    return declared, {name: lack for name, lack in missing.items() if lack}


def _require_places(
    files: Sequence[Path], columns: Columns, channels: Mapping[str, Mapping[str, Any]], kind: str, said: NewTest
) -> None:
    """Refuse to average files of several points as if they were of one."""
    if said.roving or said.same_point or columns.places or not of_points(files):
        return
    moved = tuple(name for name, one in channels.items() if one["role"] in ("drive", "response"))
    raise PlacesUnknownError(files, moved if kind != "frf" else ("reference", "response"))


def _called(target: Path) -> str:
    """Name of a declaration, or of the folder that it is ``test.toml`` of."""
    return target.resolve().parent.name if target.name == NAME else target.stem


def _groups(files: Sequence[Path], first: Sequence[str]) -> list[Sequence[str]]:
    """Return the groups of every file; ResultFileError where one has none, as the first file has."""
    found: list[Sequence[str]] = []
    for file, columns in zip(files, read_each(files), strict=True):
        if not columns.groups:
            raise ResultFileError(
                f"{file}: its channels are not in groups, as in the first file ({', '.join(first[:5])}); make a "
                "test of each"
            )
        found.append(columns.groups)
    return found


def new_campaign(
    target: Path,
    plate: tuple[float, float, float, float] | None,
    title: str,
    files: Sequence[Path] = (),
    said: NewTest | None = None,
) -> tuple[Path, list[str]]:
    """Write ``campaign.toml`` into the folder `target`, or as the file of that name.

    Parameters
    ----------
    plate : (float, float, float, float) or None
        Length along x and y, thickness, m, and mass, kg; None for those of the example.
    title : str
        Empty for that of the folder.
    files : sequence of Path
        A recorder's TDMS files in a layout of its own, one a sweep; the first is looked into.
    said : NewTest, optional
        What is known of their channels.

    Returns
    -------
    file : Path
    missing : list of str
        What the files do not contain, to be completed by hand.

    Raises
    ------
    ResultFileError
        Where there is a declaration already, for files that cannot be read, and channels without a drive.
    """
    file = target if target.suffix == ".toml" else target / DECLARATION
    if file.exists():
        raise ResultFileError(f"{file}: is there already; name another with --out, or remove it")
    table = read_table(shipped("pp-plate") / DECLARATION)
    table["title"] = title or file.resolve().parent.name
    if plate is not None:
        table["plate"] |= dict(zip(("length_x", "length_y", "thickness", "mass"), plate, strict=True))
    missing = _recorded(table, files, said or NewTest(None, {}, {})) if files else []
    sweeps = file.resolve().parent / SWEEPS
    elsewhere = [one.name for one in files if one.resolve().parent != sweeps]
    if elsewhere:
        missing.append(f"sweeps are read from {sweeps}: put {len(elsewhere)} files there, {elsewhere[0]}, ...")
    write_text(file, toml_text(table, CAMPAIGN_HEAD))
    return file, missing


def _recorded(table: dict[str, Any], files: Sequence[Path], said: NewTest) -> list[str]:
    """Add ``[channels]`` and ``[sweeps]`` of a recorder's files to a campaign's table; return what is missing."""
    from app.files.results.transfers_file import NAMED

    others = [one for one in files if one.suffix.lower() != ".tdms"]
    if others:
        raise ResultFileError(
            f"{others[0]}: sweeps of a campaign are TDMS files; FRFs of others: flexura new plate; their signals: "
            "flexura new test, and then flexura new plate test.toml"
        )
    columns = _of_one_group(read_columns(files[0]))
    guessed = guessed_channels(files[0], columns, said)
    sensors = [patch["id"] for patch in table["patch"] if patch["role"] == "sensor"]
    channels, missing = _recorded_channels(guessed, columns, sensors)
    drives = [name for name, one in channels.items() if one["role"] == "drive"]
    if len(drives) != 1:
        raise ResultFileError(
            f"{files[0]}: one drive needed, found {', '.join(drives) or 'none'}; name it with --drive NAME. It "
            f"holds: {', '.join(channels)}"
        )
    if drives[0] in columns.rates:
        table["acquisition"]["sample_rate"] = columns.rates[drives[0]]
    else:
        missing.append(f"no sample rate in the file; {table['acquisition']['sample_rate']:g} Hz is used")
    level = table["protocol"]["levels"][0]
    named = {one.name: NAMED.fullmatch(one.stem) for one in files}
    table["channels"] = channels
    table["sweeps"] = {
        name: {"temperature": float(found[1]) if found else 20.0, "level": level} for name, found in named.items()
    }
    missing += [
        f"{name!r}: its name gives no temperature; 20 °C is used" for name, found in named.items() if not found
    ]
    return missing


def _recorded_channels(
    guessed: Mapping[str, dict[str, Any]], columns: Columns, sensors: Sequence[str]
) -> tuple[dict[str, dict[str, Any]], list[str]]:
    """Return the declaration of a recorder's channels, and what is missing in it."""
    missing: list[str] = []
    channels: dict[str, dict[str, Any]] = {}
    count = {"drive": 0, "response": 0}
    for name, one in guessed.items():
        role = one["role"] if one["role"] in count else "unused"
        channels[name] = {"role": role}
        if role == "unused":
            continue
        count[role] += 1
        if role == "response":
            channels[name]["at"] = f"S{count[role]}"
            if channels[name]["at"] not in sensors:
                missing.append(f"{name!r} is read at S{count[role]}: declare a patch or sensor of that id")
        channels[name] |= {key: one[key] for key in ("unit", "sensitivity") if one.get(key)}
        if name not in columns.units and one["unit"] == "V" and "sensitivity" not in one:
            missing.append(f"{name!r}: the file gives no unit; V is assumed")
    return channels, missing


def _of_one_group(columns: Columns) -> Columns:
    """Columns without the group before their name, where several groups, one a repeat, hold the same channels."""
    short = {name: columns.channels.get(name, name) for name in columns.values}
    return Columns(
        {short[name]: values for name, values in columns.values.items()},
        {short[name]: unit for name, unit in columns.units.items()},
        {short[name]: rate for name, rate in columns.rates.items()},
    )


def points_of_table(path: Path) -> dict[str, list[float]]:
    """Read nodes and their places.

    Parameters
    ----------
    path : Path
        Table of four columns: number of the node, x, y, z; in m, or in the unit that stands behind their names.

    Raises
    ------
    ResultFileError
        Where it holds something else; the message names the row.
    """
    read = read_columns(path)
    names = _coordinates(list(read.values))
    columns = [read.values[name] for name in names]
    if len(columns) != 4 or len({len(column) for column in columns}) > 1:
        raise ResultFileError(f"{path}: {len(columns)} columns; node, x, y and z (m) of all nodes are needed")
    metres = [_metres(path, name, read.units.get(name)) for name in names[1:]]
    table = np.column_stack(columns).real * [1.0, *metres]
    places: dict[str, list[float]] = {}
    for row, (node, x, y, z) in enumerate(table, start=1):
        if not np.isfinite([node, x, y, z]).all() or node < 1 or node != round(node):
            message = (
                f"node {node:g} at {x:g}, {y:g}, {z:g}; allowed: a whole number from 1, and three numbers in m"
            )
            raise ResultFileError(f"{path}: row {row}: {message}")
        if str(round(node)) in places:
            raise ResultFileError(f"{path}: row {row}: node {node:g} occurs twice; give it one place")
        places[str(round(node))] = [float(x), float(y), float(z)]
    return places


COORDINATE = re.compile(r"\s*([xyz])(?:\s*coord\w*)?(?:[\s_/]*\(?([a-zµ]+)\)?)?\s*", re.IGNORECASE)
"""``x``, ``X_mm``, ``y / mm``: which coordinate, and its unit."""


def _coordinates(names: list[str]) -> list[str]:
    """Return the columns of a table of nodes in the order node, x, y, z, where their names say which is which."""
    axes = {found[1].lower(): name for name in names if (found := COORDINATE.fullmatch(name))}
    others = [name for name in names if name not in axes.values()]
    return [*others, *(axes[axis] for axis in "xyz")] if len(axes) == 3 and len(others) == 1 else names


def _metres(path: Path, name: str, written: str | None) -> float:
    """Metres of one unit of a coordinate."""
    behind = COORDINATE.fullmatch(name)
    text = written or (behind[2] if behind else None) or "m"
    try:
        found = unit(text)
    except ValueError as error:
        raise ResultFileError(f"{path}: column {name!r}: {error}") from error
    if found.quantity != "displacement":
        known = ", ".join(SCALES["displacement"])
        raise ResultFileError(f"{path}: column {name!r} is in {text}; allowed: {known}")
    return found.scale
