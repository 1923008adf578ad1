"""Campaigns of one plate, each driven by actuators of its own, joined to one campaign.

A rig has one output: a campaign is acquired with every actuator in turn, the others shorted. What they have in
common, all but who drove and how strongly, has to be equal.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from analysis.experiment import Experiment
from analysis.progress import Progress
from analysis.recordings.campaign import Campaign, Sweep
from app.files.campaign_error import CampaignFileError, Problem
from app.files.campaigns.coverage import coverage_problems, missing_places
from app.files.campaigns.folder import read_campaign_folder
from app.files.campaigns.kind import PROTOCOL, is_campaign_folder, is_recorded_campaign
from app.files.campaigns.loading import not_a_campaign
from app.files.campaigns.recorded import Recording, read_recording


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
