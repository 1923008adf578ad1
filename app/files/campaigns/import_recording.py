"""A recorded campaign becomes a campaign folder: whole, or not there; a killed import is taken up again.

The folder is built under the name ``OUT.part`` and renamed when it is finished. A kill leaves the
``.part`` folder; the same import then keeps every sweep in it that is whole, and the result is the
same, bit by bit, as that of an undisturbed one. Where more sweeps have come since an import, the new
folder takes the place of the old one, which is renamed ``OUT.old.part`` and removed.

Campaigns of one plate, each driven by actuators of its own, joined to one campaign.

A rig has one output: a campaign is acquired with every actuator in turn, the others shorted. What they have in
common, all but who drove and how strongly, has to be equal.
"""

import json
import shutil
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from analysis.experiment import Experiment
from analysis.progress import Progress
from analysis.recordings.campaign import Campaign, Sweep
from app.files.acquisition import events
from app.files.atomic import PARTIAL, force_folder_to_disk
from app.files.bad_file import quoted
from app.files.campaign_error import CampaignFileError, Problem
from app.files.campaigns.coverage import coverage_problems, missing_places, place_of
from app.files.campaigns.folder import (
    INDEX,
    SWEEPS,
    Source,
    digest,
    file_name,
    frozen_protocol,
    read_campaign_folder,
    read_protocol,
    read_sweep_file,
    remove_unfinished,
    sweep_paths,
    write_index,
    write_protocol,
    write_sweep,
)
from app.files.campaigns.kind import DECLARATION, PROTOCOL, is_campaign_folder, is_recorded_campaign
from app.files.campaigns.loading import not_a_campaign
from app.files.campaigns.recorded import Recording, read_recording
from app.files.disk_room import RESULTS, UnwrittenFileError, require_room
from app.files.folder_lock import folder_lock

OUR_NAMES = {PROTOCOL, SWEEPS, events.NAME, INDEX}


@dataclass(frozen=True)
class Imported:
    """What an import came to.

    Attributes
    ----------
    folder : Path
        The campaign folder.
    recording : Recording
        What was read.
    state : str
        ``imported``, ``completed`` (a killed one was taken up again), ``renewed`` (more sweeps had come since, or
        it was declared anew) or ``unchanged`` (it was there already).
    """

    folder: Path
    recording: Recording
    state: Literal["imported", "completed", "renewed", "unchanged"]


def import_recording(
    folder: Path,
    out: Path | None = None,
    allow_missing: bool = False,
    report: Progress = lambda stage, share: None,
    actuator: str | None = None,
) -> Imported:
    """Import a recorded campaign.

    Parameters
    ----------
    folder : Path
        In the format ``recorded-campaign/1``.
    out : Path, optional
        The campaign folder to make; by default ``FOLDER-campaign`` beside `folder`, of one of several actuators
        ``FOLDER-ACTUATOR-campaign``.
    allow_missing : bool
        Take what is there where the protocol asks for more, leave out sweeps that are no
        measurement, and note both.
    report : callable, optional
        Called with the stage's name and the share of it done.
    actuator : str, optional
        See `read_recording`.

    Returns
    -------
    Imported
        The folder, what was read, and what was done.

    Raises
    ------
    CampaignFileError
        For everything wrong with `folder`, or because `out` is taken or cannot be written.
    """
    if not is_recorded_campaign(folder):
        raise _already_one(folder) if is_campaign_folder(folder) else not_a_campaign(folder)
    recording = read_recording(folder, allow_missing, report, actuator)
    source = folder.resolve()
    which = "" if actuator is None else f"-{actuator}"
    target = (out or source.with_name(f"{source.name}{which}-campaign")).resolve()
    return _into(target, recording, [folder], report)


def import_read(recording: Recording, folder: Path, out: Path, report: Progress) -> Imported:
    """Import a recorded campaign that was read already; one of the same sweeps, declared otherwise, is replaced.

    Parameters
    ----------
    folder : Path
        It was read from.
    out : Path
        The campaign folder to make.
    report : callable
        Called with the stage's name and the share of it done.

    Raises
    ------
    CampaignFileError
        Where `out` is taken or cannot be written.
    """
    return _into(out.resolve(), recording, [folder], report, declared_anew=True)


def import_joined(
    folders: Sequence[Path], out: Path, allow_missing: bool = False, report: Progress = lambda stage, share: None
) -> Imported:
    """Import campaigns that differ in who drove the plate as one.

    Parameters
    ----------
    folders : sequence of Path
        Recorded, imported or acquired campaigns.
    out : Path
        The campaign folder to make.
    allow_missing : bool
        As of `import_recording`.

    Raises
    ------
    CampaignFileError
        For everything wrong with them, and where they do not belong together.
    """
    return _into(out.resolve(), read_joined(folders, allow_missing, report), folders, report)


def _into(
    target: Path, recording: Recording, folders: Sequence[Path], report: Progress, *, declared_anew: bool = False
) -> Imported:
    """Make the campaign folder; `declared_anew` replaces one of the same sweeps with another declaration."""
    for source in (folder.resolve() for folder in folders):
        if target == source or source in target.parents:
            raise CampaignFileError(
                target, [Problem("", "--out", str(target), f"a folder outside the recording {source.name}")]
            )
    read = recording.campaign
    protocol = frozen_protocol(read.name, read.experiment, read.hashes, level_units=read.level_units)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with folder_lock(target):
            if _is_there(target, protocol, declared_anew=declared_anew):
                return Imported(target, recording, "unchanged")
            samples = sum(sweep.drive.nbytes + sweep.responses.nbytes for sweep in read.sweeps)
            require_room(target, samples + RESULTS, "--out")
            return Imported(target, recording, _build(target, protocol, recording, report))
    except UnwrittenFileError:
        raise
    except OSError as error:
        seen = f"cannot be written: {error.strerror or error}"
        raise CampaignFileError(
            target, [Problem("", "", seen, "a folder on a writable disk", "use --out")]
        ) from error


def _already_one(folder: Path) -> CampaignFileError:
    remedy = f"complete or not, the other verbs take it: flexura identify {quoted(folder)}"
    return CampaignFileError(folder, [Problem("", "", "a campaign folder already", "a recorded campaign", remedy)])


def _is_there(target: Path, protocol: dict[str, Any], *, declared_anew: bool) -> bool:
    """Whether the very same campaign is in place; CampaignFileError if something else is."""
    if not target.exists():
        return False
    if target.is_dir() and not any(target.iterdir()):
        target.rmdir()  # an empty folder made beforehand; the finished one takes its name
        return False
    if target.is_dir() and is_campaign_folder(target):
        there, _ = read_protocol(target)
        if _alike(there, protocol, ("name", "experiment", "level_units", "source", "acquired")):
            read_campaign_folder(target)  # raises if it was damaged since
            return True
        if _has_grown(there, protocol, declared_anew=declared_anew):
            return False
        seen = f"holds another campaign ({there['name']!r}, protocol {there['sha256'][:12]})"
        if changed := _of_other_files(there, protocol):
            seen = f"holds what was imported from other files: {changed}"
    else:
        seen = "exists and is no campaign"
    remedy = "choose another with --out, or remove it"
    if declared_anew:
        remedy = "choose another with --set campaign=FOLDER, or remove it; stages read the recording where it is"
    raise CampaignFileError(target, [Problem("", "", seen, "a new folder, or this same campaign", remedy)])


def _has_grown(there: dict[str, Any], protocol: dict[str, Any], *, declared_anew: bool) -> bool:
    """Whether an import was of this same campaign when it had fewer sweeps, or, if allowed, another declaration.

    Its sweeps are all among those now: nothing that was imported is lost.
    """
    if "acquired" in there or there["name"] != protocol["name"]:
        return False
    if declared_anew:
        return not _of_other_files(there, protocol)
    same = _alike(there, protocol, ("experiment", "level_units"))
    return same and dict(there["source"]).items() <= protocol["source"].items()


def _of_other_files(there: dict[str, Any], protocol: dict[str, Any]) -> str:
    """Name the files of an import, the declaration left aside, that are not the same in the recording now."""
    now = protocol["source"]
    changed = [name for name, digest in there["source"].items() if name != DECLARATION and now.get(name) != digest]
    return ", ".join(changed[:3]) + (f" and {len(changed) - 3} more" if len(changed) > 3 else "")


def _alike(there: dict[str, Any], protocol: dict[str, Any], keys: Sequence[str]) -> bool:
    """Whether two protocols say the same; a key of the declaration that came later is there as by default."""
    one, other = (
        {**each, "experiment": Experiment.model_validate_json(json.dumps(each["experiment"]))}
        for each in (there, protocol)
    )
    return all(one.get(key) == other.get(key) for key in keys)


def _build(
    target: Path, protocol: dict[str, Any], recording: Recording, report: Progress
) -> Literal["imported", "completed", "renewed"]:
    partial, old = (target.with_name(target.name + ending) for ending in (PARTIAL, f".old{PARTIAL}"))
    resumed = _prepare(partial, protocol)
    try:
        (partial / SWEEPS).mkdir(exist_ok=True)
        _write_sweeps(partial, recording, report)
        _note(partial, recording)
        write_index(partial)
        force_folder_to_disk(partial)
        renewed = target.exists()
        if renewed:  # no system exchanges two folders in one step; the recordings are there, whatever happens
            shutil.rmtree(old, ignore_errors=True)
            target.rename(old)
        partial.rename(target)
    except BaseException:
        shutil.rmtree(partial, ignore_errors=True)
        if old.exists() and not target.exists():
            old.rename(target)
        raise
    force_folder_to_disk(target.parent)
    shutil.rmtree(old, ignore_errors=True)
    return "renewed" if renewed else "completed" if resumed else "imported"


def _prepare(partial: Path, protocol: dict[str, Any]) -> bool:
    """Make the unfinished folder ready; True if a killed import of this same recording is taken up."""
    if partial.exists():
        strangers = sorted(
            child.name for child in partial.iterdir() if child.name.removesuffix(PARTIAL) not in OUR_NAMES
        )
        if strangers:
            seen = f"exists already and holds {', '.join(strangers[:4])}"
            raise CampaignFileError(partial, [Problem("", "", seen, "nothing of this name", "move it away")])
        if _frozen_in(partial) == protocol["sha256"]:
            remove_unfinished(partial)
            return True
        shutil.rmtree(partial)
    partial.mkdir()
    try:
        write_protocol(partial, protocol)
    except BaseException:  # the file may be there: the disk can refuse as late as when its name is forced to it
        shutil.rmtree(partial, ignore_errors=True)
        raise
    return False


def _frozen_in(partial: Path) -> str:
    try:
        return str(read_protocol(partial)[0]["sha256"])
    except CampaignFileError:
        return ""


def _write_sweeps(partial: Path, recording: Recording, report: Progress) -> None:
    campaign = recording.campaign
    outputs = campaign.experiment.outputs
    sensors = tuple(output.id for output in outputs)
    units = tuple(output.unit for output in outputs)
    wanted = set()
    for done, sweep in enumerate(campaign.sweeps):
        report("writing", done / len(campaign.sweeps))
        place = place_of(campaign.experiment.protocol, sweep)
        assert place is not None  # noqa: S101 (a recording with a sweep out of place was refused)
        path = partial / SWEEPS / file_name(sweep, place)
        wanted.add(path)
        finished, _ = read_sweep_file(path, path.name) if path.exists() else (None, None)
        if finished is None or digest(finished) != digest(sweep):
            source = recording.files[sweep.step]
            drive = campaign.experiment.inputs[sweep.source].unit
            write_sweep(path, sweep, sensors, Source(source, campaign.hashes[source]), units=(drive, *units))
    for path in sweep_paths(partial):
        if path not in wanted:
            path.unlink()
    report("writing", 1.0)


def _note(partial: Path, recording: Recording) -> None:
    """Record what was imported, left out and missing, each once however often the import was killed."""
    happened: list[dict[str, Any]] = [{"event": "imported", "sweeps": len(recording.campaign.sweeps)}]
    happened += [{"event": "left out", "why": str(problem)} for problem in recording.left_out]
    happened += [{"event": "missing", "place": str(place)} for place in recording.missing]
    known = events.read_events(partial)
    for event in happened:
        if event not in known:
            events.append_event(partial, event)


def read_joined(
    folders: Sequence[Path], allow_missing: bool = False, report: Progress = lambda stage, share: None
) -> Recording:
    """Read several campaigns as one.

    Parameters
    ----------
    folders : sequence of Path
        Recorded, imported or acquired campaigns.
    allow_missing : bool
        As of `read_recording`.
    report : callable, optional
        Called with the stage's name and the share of it done.

    Returns
    -------
    Recording
        Sweeps of the first, then of the next; files by the number and the name of their campaign.

    Raises
    ------
    CampaignFileError
        With every problem of a campaign, and where they differ in more than what drove.
    """
    parts = []
    for number, folder in enumerate(folders):
        parts.append(_read(folder, allow_missing))
        report("reading", (number + 1) / len(folders))
    experiment = _joined(folders, [part.campaign.experiment for part in parts])
    places = {one.id: place for place, one in enumerate(experiment.inputs)}
    sweeps: list[Sweep] = []
    files: dict[int, str] = {}
    hashes: dict[str, str] = {}
    for number, part in enumerate(parts, 1):
        within = f"{number}-{part.campaign.name}/"
        hashes |= {within + name: digest for name, digest in part.campaign.hashes.items()}
        inputs = part.campaign.experiment.inputs
        first = max((sweep.step for sweep in sweeps), default=-1) + 1
        for sweep in part.campaign.sweeps:
            files[first + sweep.step] = within + part.files[sweep.step]
            sweeps.append(replace(sweep, step=first + sweep.step, source=places[inputs[sweep.source].id]))
    named = {files[sweep.step]: sweep for sweep in sweeps}
    units = _level_units(experiment, [part.campaign for part in parts])
    problems = list(coverage_problems(experiment.protocol, named, units))
    if problems:
        raise CampaignFileError(folders[0], problems)
    missing = missing_places(experiment.protocol, named, units)
    left_out = tuple(problem for part in parts for problem in part.left_out)
    other = units if units != experiment.level_units else ()
    return Recording(Campaign(folders[0].name, experiment, tuple(sweeps), hashes, other), files, missing, left_out)


def _level_units(experiment: Experiment, parts: Sequence[Campaign]) -> tuple[str, ...]:
    """Return the unit of every input's levels: an acquired campaign's are volts before its exciter."""
    unit = {
        source.id: unit
        for part in parts
        for source, unit in zip(
            part.experiment.inputs, part.level_units or part.experiment.level_units, strict=True
        )
    }
    return tuple(unit[source.id] for source in experiment.inputs)


def _read(folder: Path, allow_missing: bool) -> Recording:
    if is_recorded_campaign(folder):
        return read_recording(folder, allow_missing)
    if not is_campaign_folder(folder):
        raise not_a_campaign(folder)
    campaign = read_campaign_folder(folder)
    names = [name for name in campaign.hashes if name != PROTOCOL]
    files = {sweep.step: name for sweep, name in zip(campaign.sweeps, names, strict=True)}
    return Recording(campaign, files, ())


def _joined(folders: Sequence[Path], experiments: Sequence[Experiment]) -> Experiment:
    """Return the declaration of all; CampaignFileError where they do not belong together."""
    first = experiments[0]
    common = _without_drives(first)
    problems = [
        Problem("", key, f"not that of {folders[0]}", "the same plate, patches, sensors, cards and protocol")
        for one in experiments[1:]
        for key, value in _without_drives(one).items()
        if value != common[key]
    ]
    driving = [one.id for experiment in experiments for one in experiment.inputs]
    twice = sorted({one for one in driving if driving.count(one) > 1})
    if twice:
        problems.append(Problem("", "actuator", f"{', '.join(twice)} drove in several", "each in one campaign"))
    if problems:
        raise CampaignFileError(folders[1], problems)
    return joined_declaration(experiments)


def joined_declaration(experiments: Sequence[Experiment]) -> Experiment:
    """Return the declaration of one campaign in which the inputs of all drive in turn; all else is the first's."""
    first = experiments[0]
    driving = {one.id for experiment in experiments for one in experiment.inputs}
    return Experiment.model_validate(
        first.model_dump(mode="json")
        | {
            "patch": [
                one.model_dump(mode="json") | ({"role": "actuator"} if one.id in driving else {})
                for one in first.patch
            ],
            "drive": [drive.model_dump(mode="json") for one in experiments for drive in one.drive],
            "protocol": first.protocol.model_dump(mode="json")
            | {"levels": list(dict.fromkeys(level for one in experiments for level in one.protocol.levels))},
        }
    )


def _without_drives(experiment: Experiment) -> dict[str, Any]:
    """Return all that is declared but who drove, how strongly, and in which room."""
    declared = experiment.model_dump(mode="json", exclude={"title", "operator", "date", "drive", "oven"})
    for patch in declared["patch"]:
        patch["role"] = "shorted" if patch["role"] == "actuator" else patch["role"]
    declared["protocol"].pop("levels")
    return declared
