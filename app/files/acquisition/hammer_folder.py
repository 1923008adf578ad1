"""The folder of a hammer test: a finished file for every hit, and declarations with which other verbs read them.

``test.toml`` makes a modal test of it (`flexura identify FOLDER`), ``plate.toml`` a plate with FRFs (`flexura
update FOLDER`); both are written anew with every hit, and name the hits that count. Of several temperatures each
has a test of its own, ``set-point-1.toml`` and so on.

Hits of a hammer test whose temperature is in doubt: noted in their files, and later in the log.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from app.files.acquisition import events
from app.files.acquisition.events import later_doubts, read_events
from app.files.acquisition.same_experiment import REWIRED, changed_wiring, differences, without_wiring
from app.files.atomic import PARTIAL, atomic_hdf5, force_folder_to_disk, write_json, write_text
from app.files.bad_file import ResultFileError
from app.files.campaign_error import CampaignFileError, Problem
from app.files.campaigns.folder import Source
from app.files.campaigns.kind import HAMMER_TEST, is_hammer_folder
from app.files.declarations.hammer_experiment import HammerExperiment
from app.files.declarations.modal_test import FORMAT as OF_TEST
from app.files.declarations.modal_test import NAME as TEST
from app.files.declarations.plate import FORMAT as OF_PLATE
from app.files.declarations.plate import NAME as PLATE
from app.files.folder_lock import writable
from app.files.hdf5_file import Hdf5FileError, opened_hdf5
from app.files.parsed_text import parse_json, read_text
from app.files.provenance import provenance, stamp
from app.files.settings_toml import toml_text
from drivers.hammer.judged_hit import HammerProgress, HitJudge, HitTemperature, JudgedHit, KeptHit

FORMAT = "hammer-campaign/1"
REJECTED = "rejected"
FIRST_SENSOR = 901
"""Node of the first sensor: above those of points that are hit."""
HEAD = """Written by flexura acquire, anew with every hit: it names the hits that count.
To change it, copy it under another name beside this file."""


class HammerFolder:
    """A folder open for a hammer test; made by `open_hammer_folder`.

    Parameters
    ----------
    folder : Path
    experiment : HammerExperiment
    source : Source
        The experiment's file.
    judge : HitJudge
    """

    def __init__(self, folder: Path, experiment: HammerExperiment, source: Source, judge: HitJudge) -> None:
        self.folder = folder
        self._experiment = experiment
        self._judge = judge
        self._made_from = provenance({source.file: source.sha256})
        self._files: dict[int, tuple[Path, KeptHit, float]] = {}
        problems = []
        for path in sorted((folder / HITS).glob("*.h5")):
            try:
                with opened_hdf5(path) as file:
                    kept = KeptHit(*(int(file.attrs[name]) for name in ("number", "set_point", "point")))
                    self._files[kept.number] = (path, kept, float(file.attrs["temperature"]))
            except Hdf5FileError as error:
                problems.append(_damaged(path, error))
        if problems:
            raise CampaignFileError(folder, problems)

    def kept(self) -> Sequence[KeptHit]:
        """Return the accepted hits that are there, whole, undone ones too."""
        return [kept for _, kept, _ in self._files.values()]

    def measured(self, hit: KeptHit) -> JudgedHit:
        """Read a hit, and judge it again."""
        path = self._files[hit.number][0]
        try:
            with opened_hdf5(path) as file:
                signals = [np.asarray(file[name][()], dtype=float) for name in self._experiment.channels]
                rate = float(file.attrs["sample_rate"])
        except Hdf5FileError as error:
            raise CampaignFileError(self.folder, [_damaged(path, error)]) from error
        return self._judge.judge_measured(signals[0], np.array(signals[1:]), rate)

    def keep(self, hit: JudgedHit, kept: KeptHit, temperature: HitTemperature, date: str) -> None:
        """Write an accepted hit, whole or not at all; nothing opens the file for writing again."""
        path = self.folder / HITS / f"{kept.number:05d}_point{kept.point + 1:03d}.h5"
        self._write(path, hit, kept, temperature, date)
        self._files[kept.number] = (path, kept, temperature.value)

    def put_aside(self, hit: JudgedHit, kept: KeptHit, temperature: HitTemperature, date: str) -> None:
        """Write a rejected hit where no declaration names it."""
        path = self.folder / REJECTED / f"{kept.number:05d}_point{kept.point + 1:03d}.h5"
        self._write(path, hit, kept, temperature, date)

    def log(self, event: Mapping[str, Any]) -> None:
        """Append an event to ``events.jsonl``."""
        events.append_event(self.folder, dict(event))

    def events(self) -> list[dict[str, Any]]:
        """Read every event."""
        return events.read_events(self.folder)

    def declare(self, progress: HammerProgress) -> None:
        """Write ``test.toml`` and ``plate.toml`` of the hits that count; remove them where none does."""
        made = {}
        for number, temperature in enumerate(self._experiment.temperatures):
            hits = [hit for hit in progress.valid if hit.set_point == number]
            name = TEST if temperature is None else f"set-point-{number + 1}.toml"
            if hits:
                made[name] = hits
                write_text(self.folder / name, toml_text(self._test(hits), HEAD))
            else:
                (self.folder / name).unlink(missing_ok=True)
        points = [{hit.point for hit in hits} for hits in made.values()]
        common = sorted(set.intersection(*points)) if points else []
        if common:
            write_text(self.folder / PLATE, toml_text(self._plate(list(made), common), HEAD))
        else:
            (self.folder / PLATE).unlink(missing_ok=True)

    def _write(self, path: Path, hit: JudgedHit, kept: KeptHit, temperature: HitTemperature, date: str) -> None:
        experiment = self._experiment
        with atomic_hdf5(path) as file:
            for name, value in (("number", kept.number), ("set_point", kept.set_point), ("point", kept.point)):
                file.attrs[name] = value
            place = experiment.mallet.places[kept.point]
            file.attrs["place_m"] = json.dumps(place)
            file.attrs["temperature"] = temperature.value
            if temperature.doubt:
                file.attrs[DOUBT] = temperature.doubt
            file.attrs["start_time"] = date
            file.attrs["sample_rate"] = hit.sample_rate
            file.attrs["peak_n"] = hit.peak
            if hit.rejected:
                file.attrs["rejected"] = hit.rejected
            signals = (hit.force, *hit.responses)
            for name, unit, samples in zip(experiment.channels, experiment.units, signals, strict=True):
                data = file.create_dataset(name, data=samples.astype("<f4"))
                data.attrs["unit"] = unit
                data.attrs["sample_rate"] = hit.sample_rate
            stamp(file, self._made_from)

    def _test(self, hits: Sequence[KeptHit]) -> dict[str, Any]:
        """Return the declaration of a modal test."""
        experiment = self._experiment
        force, *sensors = experiment.channels
        full_scales = self._judge.full_scales
        channels: dict[str, Any] = {
            force: {"role": "drive", "at": "1:+z", "full_scale": full_scales[0]},
        }
        for number, (name, largest) in enumerate(zip(sensors, full_scales[1:], strict=True)):
            channels[name] = {
                "role": "response",
                "at": f"{FIRST_SENSOR + number}:{_normal(experiment, number)}",
                "full_scale": largest,
            }
        moved = f"{'-' if experiment.mallet.side == 'top' else '+'}z"
        places = {str(number): (*place, 0.0) for number, place in enumerate(experiment.mallet.places, 1)}
        places |= {
            str(FIRST_SENSOR + number): (*place, 0.0)
            for number, place in enumerate(
                p for sensor in experiment.sensor for p in sensor.places(experiment.plate)
            )
        }
        temperatures = [self._files[hit.number][2] for hit in hits]
        return {
            "format": OF_TEST,
            "title": experiment.title,
            "operator": experiment.operator or None,
            "kind": "hammer",
            "temperature": round(float(np.mean(temperatures)), 3),
            "channels": channels,
            "points": places,
            "hammer": {
                "trigger": experiment.hammer.trigger,
                "pretrigger": experiment.hammer.pretrigger,
                "duration": experiment.hammer.duration,
                "double_hit": experiment.hammer.double_hit,
                "coupling": experiment.hammer.coupling,
            },
            "record": [
                {
                    "file": f"{HITS}/{self._files[hit.number][0].name}",
                    "at": {force: f"{hit.point + 1}:{moved}"},
                }
                for hit in sorted(hits, key=lambda one: (one.point, one.number))
            ],
        }

    def _plate(self, tests: Sequence[str], common: Sequence[int]) -> dict[str, Any]:
        """Return the declaration of a plate with the FRFs of the points that were hit in all these tests."""
        experiment = self._experiment
        mallet = experiment.mallet
        drive: dict[str, Any] = {"id": mallet.id}
        if mallet.roves:
            drive |= {"points": [mallet.places[n] for n in common], "nodes": [n + 1 for n in common]}
        else:
            drive["point"] = mallet.places[0]
        drive |= {"radius": mallet.radius, "side": mallet.side}
        declared = experiment.model_dump(mode="json", include={"plate", "string", "cable", "tolerances"})
        room = {} if experiment.oven is None else {"oven": {"room_temperature": experiment.oven.room_temperature}}
        return {
            "format": OF_PLATE,
            "title": experiment.title,
            **{name: value for name, value in declared.items() if value not in ([], {}, None)},
            **room,
            "drive": [drive],
            "sensor": [one.recorded().model_dump(mode="json", exclude_none=True) for one in experiment.sensor],
            "measurement": {"band": experiment.hammer.band},
            "frf": [{"file": name, "sensors": {one: one for one in experiment.channels[1:]}} for name in tests],
        }


def _damaged(path: Path, error: Hdf5FileError) -> Problem:
    remedy = "move it out of the campaign; the same command then asks for this hit again"
    return Problem(f"{HITS}/{path.name}", "", str(error), "a file as it was written", remedy)


def _normal(experiment: HammerExperiment, number: int) -> str:
    """Return the direction in which a sensor counts, out of its face."""
    sides = [sensor.side for sensor in experiment.sensor for _ in sensor.places(experiment.plate)]
    return "+z" if sides[number] == "top" else "-z"


def open_hammer_folder(
    folder: Path, experiment: HammerExperiment, acquired: Mapping[str, Any], source: Source, judge: HitJudge
) -> HammerFolder:
    """Make the folder of a hammer test, or take one up again; the caller holds its `folder_lock`.

    Parameters
    ----------
    acquired : mapping
        The experiment and its rig, as a folder that is there must have been begun with.

    Raises
    ------
    CampaignFileError
        If it holds something else, or cannot be written.
    """
    require_our_test(folder, acquired)
    with writable(folder):
        folder.mkdir(parents=True, exist_ok=True)
        for unfinished in folder.rglob(f"*{PARTIAL}"):
            unfinished.unlink()
        if not is_hammer_folder(folder):
            made_from = provenance({source.file: source.sha256})
            begun = {"format": FORMAT, "acquired": dict(acquired), "provenance": made_from}
            write_json(folder / HAMMER_TEST, begun)
        elif wiring := changed_wiring(begun_with(folder), acquired):
            events.append_event(folder, {"event": REWIRED, "wiring": wiring})
        (folder / HITS).mkdir(exist_ok=True)
        force_folder_to_disk(folder)
        return HammerFolder(folder, experiment, source, judge)


def hammer_log(folder: Path) -> Callable[[Mapping[str, Any]], None]:
    """Return what appends an event to the log of a hammer test, once there is one in the folder."""
    return events.log_of(folder, is_hammer_folder)


def require_our_test(folder: Path, acquired: Mapping[str, Any]) -> None:
    """Raise CampaignFileError if a folder holds something else than the hammer test of this experiment."""
    if is_hammer_folder(folder):
        before = begun_with(folder)
        one, other = without_wiring(before, acquired), without_wiring(acquired, before)
        changed = differences({"acquired": one}, {"acquired": other})
        if changed:
            seen = f"holds a hammer test begun with another experiment; different: {', '.join(changed[:6])}"
            allowed = "a new folder, or this same experiment"
            raise CampaignFileError(folder, [Problem("", "", seen, allowed, "undo the change, or use --out")])
    elif folder.exists() and (
        not folder.is_dir() or {child.name for child in folder.iterdir()} - {f"{HAMMER_TEST}.part"}
    ):
        allowed = "a new folder, or one this same experiment began"
        raise CampaignFileError(folder, [Problem("", "", "exists and is no hammer test", allowed, "use --out")])


def said_of_missing_hits(folder: Path, files: Sequence[str]) -> list[str]:
    """Say how many hits there are of those that were wanted, in a sentence; none where all are there.

    Parameters
    ----------
    folder : Path
        That holds the declaration; nothing is said where it is none of a hammer test that was acquired.
    files : sequence of str
        Of the hits that count at one temperature, relative to it.

    Raises
    ------
    CampaignFileError
        Where ``hammer.json`` is damaged.
    """
    counted = [Path(name).stem for name in files if Path(name).parent == Path(HITS)]
    if not counted or not is_hammer_folder(folder):
        return []
    begun = begun_with(folder)
    try:
        points, hits = len(begun["drive"][0].get("points") or "1"), int(begun["hammer"]["hits"])
    except (KeyError, IndexError, TypeError, ValueError, AttributeError) as error:
        seen = f"does not say how many hits were wanted ({error})"
        raise CampaignFileError(folder, [Problem(HAMMER_TEST, "acquired", seen, "")]) from error
    if len(counted) >= points * hits:
        return []
    places = len({name.rpartition("_")[2] for name in counted})
    return [
        f"hammer test: {len(counted)} of {points * hits} hits, at {places} of {points} points: it was "
        "interrupted, or points were skipped; flexura acquire continues it, --again for skipped points"
    ]


def begun_with(folder: Path) -> dict[str, Any]:
    """Return the experiment with which a folder was begun, and its rig; CampaignFileError where it is damaged."""
    remedy = "move the folder away and begin anew"
    try:
        begun = parse_json(read_text(folder / HAMMER_TEST))
    except (ValueError, OSError) as error:
        raise CampaignFileError(
            folder, [Problem(HAMMER_TEST, "", str(error), "a file as it was written", remedy)]
        ) from error
    acquired = begun.get("acquired") if isinstance(begun, dict) and begun.get("format") == FORMAT else None
    if not isinstance(acquired, dict):
        raise CampaignFileError(folder, [Problem(HAMMER_TEST, "format", "not read", FORMAT, remedy)])
    return acquired


HITS = "hits"
"""Folder of the accepted ones."""
DOUBT = "doubt"
"""Attribute of a hit, only where the rig doubted the plate's temperature."""


def hit_doubts(folder: Path, files: Sequence[str]) -> dict[str, str]:
    """Return why the temperatures of some hits are in doubt, by the hit as people know it.

    Parameters
    ----------
    folder : Path
        That holds the declaration; nothing is in doubt where it is none of a hammer test that was acquired.
    files : sequence of str
        Of the hits that count, relative to it.

    Raises
    ------
    CampaignFileError
        For a damaged log.
    ResultFileError
        For a hit that cannot be read.
    """
    if not is_hammer_folder(folder):
        return {}
    later, found = later_doubts(read_events(folder)), dict[str, str]()
    for name in files:
        if Path(name).parent != Path(HITS):
            continue
        try:
            with opened_hdf5(folder / name) as file:
                number, point = (int(file.attrs[key]) for key in ("number", "point"))
                doubt = later.get(number, str(file.attrs.get(DOUBT, "")))
                if doubt:
                    found[f"hit {number} (point {point + 1}, {float(file.attrs['temperature']):.1f} °C)"] = doubt
        except Hdf5FileError as error:
            raise ResultFileError(f"{folder / name}: {error}") from error
    return found
