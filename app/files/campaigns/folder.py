"""A campaign in Flexura's own form: a folder of finished files that survives a kill at any moment.

=====================  ===========================================================================
``protocol.json``      the experiment and where it came from, frozen, with its own SHA-256
``sweeps/*.h5``        one closed file for every sweep, never opened for writing again
``events.jsonl``       what happened, appended and forced to the disk
``readings.csv``       every temperature read while a rig wrote it, for people
``latest.h5``          the repeat recorded last, for ``flexura view``; never analysed
``control.json``       a pause or a stop that ``flexura view`` requests; exists only until it is done
``ending.txt``         how the last run ended, where it could not be printed: the terminal was gone
``index.h5``           links into the sweeps for people with an HDF5 viewer; made anew at will
=====================  ===========================================================================

The files are the truth: what has been done is what is there and matches its digest, not a counter.

A finished sweep is a closed HDF5 file that carries a digest of its own contents. Those of versions that did not
seal their files (see `app.files.hdf5_file`) are read, too: a measurement cannot
be made again.
"""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from pydantic import ValidationError

from analysis.experiment import Experiment
from analysis.recordings.campaign import Campaign, CampaignExtent, State, Sweep
from app.files.acquisition.events import LATEST, READINGS, later_doubts, read_events
from app.files.acquisition.events import NAME as EVENTS
from app.files.atomic import PARTIAL, atomic_hdf5, write_json
from app.files.campaign_error import CampaignFileError, Problem
from app.files.campaigns.coverage import Place, coverage_problems, missing_places
from app.files.campaigns.kind import PROTOCOL
from app.files.folder_lock import is_being_written
from app.files.hdf5_file import Hdf5FileError, opened_hdf5
from app.files.isolation import require_readable
from app.files.parsed_text import parse_json, read_text
from app.files.provenance import sha256

PLATE = ("plate_temperature_start", "plate_temperature_end")
"""Only where a sensor was on the plate."""
PROPERTIES = ("step", "direction", "level", "oven_temperature_start", "oven_temperature_end", "start_time")
DOUBT = "temperature_doubt"
"""Only where the rig doubted the plate's temperature; for people, and for the notes of results."""
REMEDY = "delete the folder and import the campaign again"
ONLY_HERE = (
    "keep the folder: what was measured is nowhere else. Put the file back from a copy, or from a campaign of the "
    "same experiment, begun with flexura acquire in another place and stopped at once"
)


@dataclass(frozen=True)
class Source:
    """What a sweep came from: a recording's file, or the experiment it was acquired for.

    Attributes
    ----------
    file : str
        Its name.
    sha256 : str
    """

    file: str
    sha256: str


def file_name(sweep: Sweep, place: Place) -> str:
    """Name of a sweep's file: ``0006_up_T+012.0.h5``."""
    return f"{sweep.step:04d}_{sweep.direction}_T{place.temperature:+06.1f}.h5"


def digest(sweep: Sweep) -> str:
    """SHA-256 of a sweep's properties and samples, the same on every machine."""
    properties = json.dumps([getattr(sweep, name) for name in _properties(sweep)])
    found = hashlib.sha256(properties.encode())
    for samples in (sweep.drive, sweep.responses):
        found.update(repr(samples.shape).encode())
        found.update(np.ascontiguousarray(samples, dtype="<f4").tobytes())
    return found.hexdigest()


def write_sweep(
    path: Path,
    sweep: Sweep,
    sensors: tuple[str, ...],
    source: Source,
    notes: Mapping[str, str | int | float] | None = None,
    units: tuple[str, ...] = (),
) -> None:
    """Write a sweep, whole or not at all; nothing opens the file for writing again.

    Parameters
    ----------
    sensors : tuple of str
        Names of the responses.
    notes : mapping, optional
        Further attributes, for people: how often it was tried, say.
    units : tuple of str, optional
        Of the drive, then of each response; volts unless given.
    """
    with atomic_hdf5(path) as file:
        for name in _properties(sweep):
            file.attrs[name] = getattr(sweep, name)
        for name, value in (notes or {}).items():
            file.attrs[name] = value
        if sweep.doubt:
            file.attrs[DOUBT] = sweep.doubt
        file.attrs["sensors"] = json.dumps(sensors)
        file.attrs["source_file"] = source.file
        file.attrs["source_sha256"] = source.sha256
        file.attrs["sweep_sha256"] = digest(sweep)
        for name, samples in (("drive", sweep.drive), ("responses", sweep.responses)):
            data = file.create_dataset(name, data=samples.astype("<f4"))
            mine = units[:1] if name == "drive" else units[1:]
            data.attrs["unit"] = json.dumps(mine) if len(set(mine)) > 1 else (mine or ("V",))[0]
        file["drive"].attrs["axes"] = "repeat, sample"
        file["responses"].attrs["axes"] = "sensor, repeat, sample"


def read_sweep_file(path: Path, name: str) -> tuple[Sweep | None, Problem | None]:
    """Read a sweep back and hold it against its digest.

    Parameters
    ----------
    name : str
        What the problem calls the file.

    Returns
    -------
    sweep : Sweep or None
    problem : Problem or None
        One of both is None.
    """
    try:
        with opened_hdf5(path, unsealed=require_readable) as file:
            stored = str(file.attrs["sweep_sha256"])
            sweep = Sweep(
                step=int(file.attrs["step"]),
                direction=str(file.attrs["direction"]),  # type: ignore[arg-type]
                level=float(file.attrs["level"]),
                oven_temperature_start=float(file.attrs["oven_temperature_start"]),
                oven_temperature_end=float(file.attrs["oven_temperature_end"]),
                start_time=str(file.attrs["start_time"]),
                drive=file["drive"][()],
                responses=file["responses"][()],
                source=int(file.attrs.get("source", 0)),
                doubt=str(file.attrs.get(DOUBT, "")),
                **{name: float(file.attrs[name]) for name in PLATE if name in file.attrs},
            )
    except Hdf5FileError as error:
        return None, Problem(name, "", f"unreadable ({error})", "a whole sweep file", REMEDY)
    if digest(sweep) != stored:
        return None, Problem(name, "sweep_sha256", stored[:12], "the digest of the samples in the file", REMEDY)
    return sweep, None


def _properties(sweep: Sweep) -> tuple[str, ...]:
    plate = () if sweep.plate_temperature_start is None else PLATE
    return (*PROPERTIES, *plate, *(("source",) if sweep.source else ()))


FORMAT = "flexura-campaign/1"
SWEEPS = "sweeps"
ENDING = "ending.txt"
INDEX = "index.h5"
MEASURE_AGAIN = "move it out of the campaign; flexura acquire measures it again"
"""What to do about a damaged sweep of a rig: the others are good."""
LARGEST_PROTOCOL = 20_000_000
"""Bytes of a protocol: it names the SHA-256 of every file imported."""


def frozen_protocol(
    name: str,
    experiment: Experiment,
    source: dict[str, str],
    acquired: dict[str, Any] | None = None,
    level_units: tuple[str, ...] = (),
) -> dict[str, Any]:
    """Return what ``protocol.json`` holds.

    Parameters
    ----------
    source : dict
        SHA-256 of every file imported, or of the experiment's file, by name.
    acquired : dict, optional
        The experiment's declaration, for a campaign of Flexura's own.
    level_units : tuple of str
        As of `Campaign`; those of an acquired campaign follow from `acquired`.

    Returns
    -------
    dict
        With the SHA-256 of all the rest.
    """
    content = {
        "format": FORMAT,
        "name": name,
        "experiment": experiment.model_dump(mode="json"),
        "source": source,
    }
    if acquired is not None:
        content["acquired"] = acquired
    if level_units:
        content["level_units"] = list(level_units)
    return content | {"sha256": _digest(content)}


def write_protocol(folder: Path, protocol: dict[str, Any]) -> None:
    """Freeze a protocol into a folder."""
    write_json(folder / PROTOCOL, protocol)


def read_protocol(folder: Path) -> tuple[dict[str, Any], Experiment]:
    """Read ``protocol.json``; CampaignFileError if it is damaged, of another format, or was edited."""
    try:
        protocol = parse_json(read_text(folder / PROTOCOL, LARGEST_PROTOCOL))
        if not isinstance(protocol, dict):
            raise TypeError(f"a {type(protocol).__name__}, not an object with keys")
        content = {key: value for key, value in protocol.items() if key != "sha256"}
        if content["format"] != FORMAT:
            raise CampaignFileError(folder, [Problem(PROTOCOL, "format", repr(content["format"]), repr(FORMAT))])
        if protocol["sha256"] != _digest(content):
            seen = "not that of the content: the file was edited or damaged"
            raise CampaignFileError(folder, [_of_protocol(folder, "sha256", seen)])
        return protocol, Experiment.model_validate_json(json.dumps(content["experiment"]))
    except CampaignFileError:
        raise
    except (OSError, KeyError, AttributeError, TypeError, ValueError, ValidationError) as error:
        raise CampaignFileError(folder, [_of_protocol(folder, "", f"unreadable ({error})")]) from error


def _of_protocol(folder: Path, key: str, seen: str) -> Problem:
    """Say what is wrong with a protocol; what a rig measured is not to be deleted for it."""
    acquired = any((folder / name).exists() for name in (READINGS, LATEST))
    return Problem(PROTOCOL, key, seen, "a frozen protocol", ONLY_HERE if acquired else REMEDY)


def _level_units(folder: Path, protocol: dict[str, Any], experiment: Experiment) -> tuple[str, ...]:
    """Return those of `Campaign`; CampaignFileError where they are not one for each input, V or its own."""
    if "acquired" in protocol:
        return ("V",) * len(experiment.inputs)  # the generator's, of a force too
    seen, own = protocol.get("level_units", []), experiment.level_units
    if seen and not (
        isinstance(seen, list)
        and len(seen) == len(own)
        and all(one in ("V", unit) for one, unit in zip(seen, own, strict=True))
    ):
        allowed = f"one of V or its own for each input: {', '.join(own)}"
        raise CampaignFileError(folder, [Problem(PROTOCOL, "level_units", repr(seen)[:200], allowed, REMEDY)])
    return tuple(seen)


def _digest(content: dict[str, Any]) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True, allow_nan=False).encode()).hexdigest()


def sweep_paths(folder: Path) -> list[Path]:
    """Finished sweep files, in the order recorded."""
    return sorted((folder / SWEEPS).glob("*.h5"))


def remove_unfinished(folder: Path) -> None:
    """Delete what a killed writer left behind."""
    for partial in folder.rglob(f"*{PARTIAL}"):
        partial.unlink()


def write_index(folder: Path) -> None:
    """Make ``index.h5`` anew: one external link for each sweep file."""
    with atomic_hdf5(folder / INDEX) as file:
        for path in sweep_paths(folder):
            file[path.stem] = h5py.ExternalLink(f"{SWEEPS}/{path.name}", "/")


@dataclass(frozen=True)
class FileMark:
    """By what a file is known to be the one that was read a moment ago.

    Attributes
    ----------
    inode, size : int
    changed : int
        Time of the last change, ns.
    """

    inode: int
    size: int
    changed: int

    @classmethod
    def of(cls, path: Path) -> "FileMark | None":
        """Take it of a file; None where there is none, or none that can be read."""
        try:
            found = path.stat()
        except OSError:
            return None
        return cls(found.st_ino, found.st_size, found.st_mtime_ns)


def read_finished_sweep(path: Path, name: str) -> tuple[Sweep, str] | Problem:
    """Read a sweep and the SHA-256 of its file, which must be the same file for both.

    A finished file is never written again, but people move and replace files: a hash of another file than the one
    that was read would vouch for samples that no result was made from.

    Parameters
    ----------
    name : str
        What a problem calls the file.

    Returns
    -------
    (Sweep, str) or Problem
    """
    before = FileMark.of(path)
    sweep, wrong = read_sweep_file(path, name)
    try:
        digest = sha256(path)
    except OSError:
        return changed(name)
    if before != FileMark.of(path):
        return changed(name)
    return wrong or changed(name) if sweep is None else (sweep, digest)


def changed(name: str) -> Problem:
    """Say that a file is not the one it was when reading began."""
    return Problem(
        name, "", "changed while it was read", "files that nobody moves or replaces", "do the same again"
    )


def read_campaign_folder(folder: Path) -> Campaign:
    """Read the finished sweeps of a campaign, and hold them against its protocol and digests.

    A rig may be writing the folder. The list of sweeps is taken once, at the start: a sweep that is finished later
    belongs to the next reading. What is missing then of an acquired campaign is in `Campaign.extent`; an imported
    campaign is complete but for what was noted when it was imported.

    Raises
    ------
    CampaignFileError
        With every damaged, doubled or misplaced sweep, and every missing one of an imported campaign; and where no
        sweep is finished.
    """
    paths, frozen = sweep_paths(folder), FileMark.of(folder / PROTOCOL)
    protocol, experiment = read_protocol(folder)
    acquired, hashes = "acquired" in protocol, {PROTOCOL: sha256(folder / PROTOCOL)}
    problems = [] if frozen == FileMark.of(folder / PROTOCOL) else [changed(PROTOCOL)]
    sweeps: dict[str, Sweep] = {}
    for path in paths:
        name = f"{SWEEPS}/{path.name}"
        read = read_finished_sweep(path, name)
        if isinstance(read, Problem):
            mend = acquired and read.remedy == REMEDY
            problems.append(replace(read, remedy=MEASURE_AGAIN) if mend else read)
        else:
            sweeps[name], hashes[name] = read
    played = _level_units(folder, protocol, experiment)
    units = played or experiment.level_units
    problems += coverage_problems(experiment.protocol, sweeps, units)
    missing = missing_places(experiment.protocol, sweeps, units)
    events = read_events(folder)
    gone = _to_come(events, missing)
    if gone and not acquired and not problems:
        shown = ", ".join(map(str, gone[:8])) + (f" and {len(gone) - 8} more" if len(gone) > 8 else "")
        problems.append(Problem(f"{SWEEPS}/", "missing", shown, "every sweep of the protocol", REMEDY))
    if not sweeps and not problems:
        problems.append(_no_sweep(folder, len(missing), len(gone)))
    if problems:
        raise CampaignFileError(folder, problems)
    doubts = later_doubts(events)
    there, extent = tuple(replace(one, doubt=doubts.get(one.step, one.doubt)) for one in sweeps.values()), None
    if missing:
        temperature = [sweep.temperature for sweep in there]
        extent = CampaignExtent.of(_state(folder, len(gone)), temperature, len(missing), len(missing) - len(gone))
    return Campaign(protocol["name"], experiment, there, hashes, played, extent).as_read()


def _to_come(events: Sequence[Mapping[str, Any]], missing: Sequence[Place]) -> list[Place]:
    """Missing sweeps that the log does not call missing: neither given up nor left out by an import."""
    known = {event["place"] for event in events if event.get("event") == "missing"}
    return [
        place
        for place in missing
        if known.isdisjoint({str(place), str(replace(place, unit="V"))})  # older logs have V for forces
    ]


def _state(folder: Path, to_come: int) -> State:
    if not to_come:
        return "ended"
    return "running" if is_being_written(folder) else "interrupted"


def _no_sweep(folder: Path, asked: int, to_come: int) -> Problem:
    """Say that there is nothing to compute with yet."""
    if not to_come:
        seen = f"holds no sweep: all {asked} were given up ({EVENTS} says why); try again: flexura acquire --again"
    elif is_being_written(folder):
        seen = f"no sweep is finished yet, of {asked}: flexura acquire is recording the first; try again later"
    else:
        seen = f"no sweep is finished yet, of {asked}: continue the campaign with flexura acquire"
    return Problem("", "", seen, "")
