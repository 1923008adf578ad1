"""What is what in TDMS files of a recorder's own layout: channels, sweeps, and which actuator drove.

Every sweep's file names its actuator in the root property ``actuator``, or ``[sweeps]`` does. Of the others,
patches are held at 0 V, as the output of an amplifier at rest holds them, and forces do not act.

``campaign.toml``: the declaration of a recorded campaign.
"""

import hashlib
import re
import tomllib
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Any, Literal

from nptdms import TdmsFile
from pydantic import Field

from analysis.channel import Channel
from analysis.declaration.strict import Declared, Temperature
from analysis.estimation.quantities import Calibration, calibration
from analysis.experiment import Experiment
from app.files.campaign_error import CampaignFileError, Problem
from app.files.campaigns.kind import DECLARATION
from app.files.campaigns.tdms_file import said_by_nptdms
from app.files.settings_toml import checked, read_table

ACTUATOR = "actuator"
"""Root property that names what drove a sweep."""
KEYS = ("channels", "sweeps")
"""Of ``campaign.toml``, beside what is declared of the experiment."""


class RecordedChannel(Declared):
    """A channel of the recorder's files: what it measures, and how its numbers become SI units."""

    role: Literal["drive", "response", "unused"]
    at: Annotated[str | None, Field(description="id of its patch, drive or sensor")] = None
    unit: str | None = None
    sensitivity: str | None = None

    def calibration(self, file_unit: str | None, measures: Channel) -> Calibration:
        """Return what its numbers mean; ValueError, with what to write, where that is not known."""
        unit = self.unit or file_unit
        if unit is None:
            raise ValueError('the file gives no unit; give unit, for example unit = "V"')
        return calibration(unit, self.sensitivity, measures.quantity)


class RecordedSweep(Declared):
    """What is known of one file besides its channels."""

    temperature: Annotated[Temperature | tuple[Temperature, Temperature], Field(description="or start and end")]
    direction: Literal["up", "down"] = "up"
    level: Annotated[float, Field(gt=0.0, le=1000.0, description="V or N, amplitude of the drive")]
    start_time: str | None = None
    actuator: Annotated[str | None, Field(description="id of what drove, where several drove in turn")] = None


class RecorderLayout(Declared):
    """Both tables; empty where the files have the layout that Flexura asks for."""

    channels: Annotated[dict[str, RecordedChannel], Field(default_factory=dict)]
    sweeps: Annotated[dict[str, RecordedSweep], Field(default_factory=dict)]

    def properties(self, file: str, of_file: Mapping[str, Any]) -> dict[str, Any]:
        """Root properties of a file, with what ``[sweeps]`` says of it; its place there is its step."""
        if file not in self.sweeps:
            return dict(of_file)
        said = self.sweeps[file]
        ends = said.temperature if isinstance(said.temperature, tuple) else (said.temperature, said.temperature)
        known = {
            "oven_temperature_start": ends[0],
            "oven_temperature_end": ends[1],
            "direction": said.direction,
            "level": said.level,
            "step": list(self.sweeps).index(file),
            **({ACTUATOR: said.actuator} if said.actuator else {}),
        }
        start = said.start_time or of_file.get("start_time") or of_file.get("DateTime")
        return {**of_file, **known, **({"start_time": start} if start else {})}

    def wired(self, experiment: Experiment, source: int = 0) -> dict[str, tuple[str, RecordedChannel]]:
        """Find the recorder's channel of each of the experiment's, by identifier; ValueError says what is missing.

        Parameters
        ----------
        source : int
            Which of its inputs drives; the drive's channels of the others are passed over.

        Returns
        -------
        dict
            Identifier to the name in the files and what is declared of it; the drive first.
        """
        found: dict[str, tuple[str, RecordedChannel]] = {}
        driving, idle = (
            experiment.inputs[source],
            {one.id for k, one in enumerate(experiment.inputs) if k != source},
        )
        for role, wanted in (("drive", (driving,)), ("response", experiment.outputs)):
            ours = [one.id for one in wanted]
            theirs = {name: one for name, one in self.channels.items() if one.role == role and one.at not in idle}
            for name, one in theirs.items():
                place = one.at or (ours[0] if len(ours) == len(theirs) == 1 else None)
                if place not in ours:
                    raise ValueError(
                        f'{name!r} has role = "{role}" and at = {one.at!r}; at has to be one of {", ".join(ours)}'
                    )
                if place in found:
                    raise ValueError(
                        f'{name!r} and {found[place][0]!r} both have at = "{place}"; one of them is unused'
                    )
                found[place] = (name, one)
            lacking = [one for one in ours if one not in found]
            if lacking:
                raise ValueError(
                    f'no channel for {", ".join(lacking)}; add one with role = "{role}", at = "{lacking[0]}"'
                )
        return {one.id: found[one.id] for one in (driving, *experiment.outputs)}

    def problems(self, file: str, experiment: Experiment, tdms_files: list[str]) -> list[Problem]:
        """Say what in both tables does not fit the experiment, or the files there are.

        Parameters
        ----------
        file : str
            Of the declaration.
        tdms_files : list of str
            Names of the files in the folder of sweeps.
        """
        problems = []
        if self.channels:
            try:
                for source in range(len(experiment.inputs)):
                    self.wired(experiment, source)
            except ValueError as error:
                problems.append(Problem(file, "channels", str(error), ""))
        there = ", ".join(tdms_files[:8]) or "none"
        problems += [
            Problem(file, f'sweeps."{name}"', "no such file", f"one of the folder sweeps: {there}")
            for name in self.sweeps
            if name not in tdms_files
        ]
        return problems


def actuators(table: Mapping[str, Any]) -> list[str]:
    """Names of all that a declaration, unchecked, says drives the plate."""
    patches = [p for p in _tables(table, "patch") if p.get("role") == "actuator"]
    return [str(one.get("id")) for one in (*patches, *_tables(table, "drive"))]


def driven_by(path: Path, table: Mapping[str, Any], actuator: str | None) -> Mapping[str, Any]:
    """Return the declaration with only the actuator named, if one is; the others are shorted or left out.

    Parameters
    ----------
    path : Path
        File of the declaration, for messages.
    table : mapping
        Its keys and values, unchecked.
    actuator : str or None
        Identifier; None leaves the declaration as it is.

    Raises
    ------
    CampaignFileError
        For an actuator that is not declared.
    """
    if actuator is None:
        return table
    names = actuators(table)
    if actuator not in names:
        allowed = ", ".join(names) or "an actuator, of which the file declares none"
        raise CampaignFileError(path.parent, [Problem(path.name, "--actuator", repr(actuator), allowed)])
    patches = [
        one | {"role": "shorted"} if one.get("role") == "actuator" and one.get("id") != actuator else one
        for one in _tables(table, "patch")
    ]
    drives = [one for one in _tables(table, "drive") if one.get("id") == actuator]
    changed = {"patch": patches, "drive": drives}
    return {**table, **{key: value for key, value in changed.items() if key in table}}


def source_of(
    name: str, properties: Mapping[str, Any], experiment: Experiment
) -> tuple[int | None, list[Problem]]:
    """Return which of an experiment's inputs drove a sweep, or what is wrong with the name of it.

    Parameters
    ----------
    name : str
        Of the file, for messages.
    properties : mapping
        Of its root.

    Returns
    -------
    source : int or None
    problems : list of Problem
    """
    names = [one.id for one in experiment.inputs]
    if len(names) == 1:
        return 0, []
    named = properties.get(ACTUATOR)
    return (names.index(named), []) if named in names else (None, [_unnamed(name, named, names)])


def _unnamed(name: str, named: object, names: Sequence[str]) -> Problem:
    seen = repr(named) if named else "nothing"
    return Problem(name, ACTUATOR, seen, " or ".join(names), "which one drove?")


def sweeps_of(
    files: Sequence[Path], actuator: str, names: Sequence[str], recorder: RecorderLayout
) -> tuple[list[Path], list[Problem]]:
    """Choose the files of the sweeps that one of several actuators drove.

    A file that cannot be read counts as one of them: its reader says why.

    Parameters
    ----------
    names : sequence of str
        All actuators declared.
    recorder : RecorderLayout
        What is declared of files that have a layout of their own.

    Returns
    -------
    chosen : list of Path
    problems : list of Problem
        Files that name none of `names`.
    """
    chosen, problems = [], []
    for path in files:
        named = _actuator_of(path, recorder)
        if named is None or named == actuator:
            chosen.append(path)
        elif named not in names:
            problems.append(_unnamed(f"sweeps/{path.name}", named, names))
    return chosen, problems


def _actuator_of(path: Path, recorder: RecorderLayout) -> str | None:
    try:
        with path.open("rb") as file, said_by_nptdms():  # a handle: see `app.files.campaigns.tdms_file`
            properties = TdmsFile.read_metadata(file).properties
        return str(recorder.properties(path.name, properties).get(ACTUATOR, ""))
    except Exception:  # noqa: BLE001 (on damaged bytes npTDMS raises what it runs into)
        return None


def _tables(table: Mapping[str, Any], key: str) -> list[dict[str, Any]]:
    found = table.get(key, [])
    return [one for one in found if isinstance(one, dict)] if isinstance(found, list) else []


FORMAT = "recorded-campaign/1"
RUN = "run"
"""Table of the options of `flexura run`: it says nothing about what was measured."""
HEADER = re.compile(r"\s*\[+\s*([\w\"'-]+)")


def read_experiment(folder: Path, actuator: str | None = None) -> Experiment:
    """Read the declaration in a recorded campaign's folder; of several actuators, the one named drives.

    Raises
    ------
    CampaignFileError
        With every missing, unknown, mistyped or implausible key.
    """
    return read_declaration(folder, actuator)[0]


def read_declaration(folder: Path, actuator: str | None = None) -> tuple[Experiment, RecorderLayout]:
    """Read the same, and what it says of files that a recorder wrote in a layout of its own."""
    path = folder / DECLARATION
    table = read_table(path)
    recorder = checked(path, {key: table[key] for key in KEYS if key in table}, RecorderLayout)
    rest = {key: value for key, value in table.items() if key not in (*KEYS, RUN)}
    for key in sorted(set(rest) - set(Experiment.model_fields)):
        meant = get_close_matches(key, KEYS, 1)
        if meant:
            problem = Problem(DECLARATION, key, "unknown key", f"[{meant[0]}]", f"did you mean {meant[0]}?")
            raise CampaignFileError(folder, [problem])
    experiment = checked(path, driven_by(path, rest, actuator), Experiment)
    idle = set(actuators(rest)) - {one.id for one in experiment.inputs}
    channels = {name: one for name, one in recorder.channels.items() if one.role != "drive" or one.at not in idle}
    return experiment, recorder.model_copy(update={"channels": channels})


def declaration_digest(path: Path) -> str:
    """SHA-256 of a declaration without its table [run]: other options of a run leave results of others valid."""
    read = path.read_bytes()
    try:
        text = read.decode("utf-8")
        declared = tomllib.loads(text)
        if RUN not in declared:
            return hashlib.sha256(read).hexdigest()
        kept = _without_run(text)
        same = tomllib.loads(kept) == {key: value for key, value in declared.items() if key != RUN}
    except (UnicodeDecodeError, tomllib.TOMLDecodeError):  # the reader says what is wrong
        return hashlib.sha256(read).hexdigest()
    return hashlib.sha256(kept.encode() if same else read).hexdigest()


def _without_run(text: str) -> str:
    """Return the text of a declaration as it was before its table [run] was appended or put in between."""
    kept: list[str] = []
    inside = False
    for line in text.splitlines(keepends=True):
        header = HEADER.match(line)
        if header:
            inside = header[1].strip("\"'") == RUN
        if not inside:
            kept.append(line)
    return "".join(kept).rstrip() + "\n"


def run_table(path: Path) -> dict[str, Any] | None:
    """Return the table [run] of a TOML file, unchecked; None where it has none."""
    return read_table(path).get(RUN)
