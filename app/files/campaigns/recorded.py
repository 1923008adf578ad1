"""A recorded campaign: ``campaign.toml`` and a TDMS file for every sweep, checked as a whole."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from analysis.experiment import Experiment
from analysis.recordings.campaign import Campaign, CampaignExtent, Sweep
from app.files.campaign_error import CampaignFileError, Problem, SignalProblem
from app.files.campaigns.channels import actuators, declaration_digest, read_declaration, sweeps_of
from app.files.campaigns.coverage import Place, coverage_problems, missing_places, places
from app.files.campaigns.kind import DECLARATION
from app.files.campaigns.tdms_sweep import read_sweep
from app.files.provenance import sha256
from app.files.settings_toml import read_table
from drivers.ni.modules import find_module

SWEEPS = "sweeps"


@dataclass(frozen=True)
class Recording:
    """A recorded campaign as read.

    Attributes
    ----------
    campaign : Campaign
        Sweeps in the order recorded; hashes of ``campaign.toml`` and every TDMS file.
    files : dict
        Name of the TDMS file of each sweep, by its step.
    missing : tuple of Place
        What the protocol asks for and the folder lacks, sweeps left out among it.
    left_out : tuple of SignalProblem
        Why sweeps that are there were left out.
    """

    campaign: Campaign
    files: dict[int, str]
    missing: tuple[Place, ...]
    left_out: tuple[SignalProblem, ...] = ()


def read_recorded_campaign(folder: Path) -> Campaign:
    """Read the sweeps that are there of a recorded campaign; see `read_recording`, and `Campaign.extent`."""
    recording = read_recording(folder, allow_absent=True)
    missing, campaign = recording.missing, recording.campaign.as_read()
    if not missing:
        return campaign
    return replace(
        campaign,
        extent=CampaignExtent.of("incomplete", [sweep.temperature for sweep in campaign.sweeps], len(missing)),
    )


def read_recording(
    folder: Path,
    allow_missing: bool = False,
    report: Callable[[str, float], None] = lambda stage, share: None,
    actuator: str | None = None,
    allow_absent: bool = False,
) -> Recording:
    """Read and check a folder in the format ``recorded-campaign/1``.

    Parameters
    ----------
    allow_missing : bool
        Take what is there where the protocol asks for more, and leave out sweeps that are no measurement.
    report : callable, optional
        Called with the stage's name and the share of it done.
    actuator : str, optional
        Of several that drove the plate one after the other: its sweeps are read, as a campaign of their own.
    allow_absent : bool
        Take what is there where the protocol asks for more, but leave out none that is there.

    Raises
    ------
    CampaignFileError
        With every problem of every file.
    """
    experiment, recorder = read_declaration(folder, actuator)
    files = _tdms_files(folder)
    problems = [
        *_experiment_problems(experiment),
        *recorder.problems(DECLARATION, experiment, [path.name for path in files]),
    ]
    names = actuators(read_table(folder / DECLARATION))
    if actuator is not None and len(names) > 1:
        files, unnamed = sweeps_of(files, actuator, names, recorder)
        problems += unnamed
    if problems or not files:
        raise CampaignFileError(folder, problems or [_no_files(folder)])
    sweeps: dict[str, Sweep] = {}
    left_out: list[SignalProblem] = []
    for done, path in enumerate(files):
        report("reading", done / len(files))
        name = f"{SWEEPS}/{path.name}"
        sweep, wrong = read_sweep(path, name, experiment, recorder)
        faults = [problem for problem in wrong if isinstance(problem, SignalProblem)]
        if allow_missing and wrong and len(faults) == len(wrong):
            left_out += faults
        else:
            problems += wrong
        if sweep:
            sweeps[name] = sweep
    report("reading", 1.0)
    problems += coverage_problems(experiment.protocol, sweeps, experiment.level_units)
    digests = {name: sha256(folder / name) for name in sweeps}
    problems += _copies(digests)
    missing = missing_places(experiment.protocol, sweeps, experiment.level_units)
    if len(sweeps) == len(files):
        problems += _idle(experiment, sweeps)
    if missing and not (allow_missing or allow_absent) and len(sweeps) == len(files):
        problems.append(_missing(missing))  # only of undamaged files: a damaged one is not missing
    if problems or not sweeps:
        raise CampaignFileError(folder, problems or left_out)
    names = sorted(sweeps, key=lambda name: sweeps[name].step)
    hashes = {DECLARATION: declaration_digest(folder / DECLARATION)}
    hashes |= {name: digests[name] for name in names}
    campaign = Campaign(folder.resolve().name, experiment, tuple(sweeps[name] for name in names), hashes)
    return Recording(campaign, {sweeps[name].step: name for name in names}, missing, tuple(left_out))


def _tdms_files(folder: Path) -> list[Path]:
    sweeps = folder / SWEEPS
    if not sweeps.is_dir():
        return []
    return sorted(
        path for path in sweeps.iterdir() if path.suffix.lower() == ".tdms" and not path.name.startswith(".")
    )


def _copies(digests: Mapping[str, str]) -> list[Problem]:
    """Files that are another one under another name, and so no measurement at their temperature."""
    first: dict[str, str] = {}
    return [
        Problem(name, "", f"a copy of {first[digest]}, byte for byte", "a measurement of its own", "remove one")
        for name, digest in digests.items()
        if first.setdefault(digest, name) != name
    ]


def _no_files(folder: Path) -> Problem:
    there = (folder / SWEEPS).is_dir()
    seen = "no TDMS file" if there else "no such folder"
    return Problem(f"{SWEEPS}/", "", seen, "one TDMS file for each sweep", "copy them from the recorder")


def _experiment_problems(experiment: Experiment) -> list[Problem]:
    """Hold the declaration against the hardware and against a sensible size."""
    problems = []
    try:
        places(experiment.protocol)
    except ValueError as error:
        problems.append(Problem(DECLARATION, "protocol", str(error), ""))
    rate, module = experiment.acquisition.sample_rate, find_module(experiment.acquisition.module)
    if module and not module.can_run_at(rate):
        nearest, n = module.nearest_rate(rate)
        allowed = f"{module.rates()[0]:g} Hz / n for the {module.name}; the nearest is {nearest:.10g} Hz (n = {n})"
        problems.append(Problem(DECLARATION, "acquisition.sample_rate", f"{rate:.10g}", allowed, "read it back"))
    return problems


def _idle(experiment: Experiment, sweeps: Mapping[str, Sweep]) -> list[Problem]:
    """Actuators that drove no sweep: nothing would be known of their gains."""
    driving = {sweep.source for sweep in sweeps.values()}
    idle = [one.id for source, one in enumerate(experiment.inputs) if source not in driving]
    remedy = 'give a patch that never drives role = "shorted", and remove its [[drive]]'
    return [
        Problem(DECLARATION, "patch, drive", f"{name} drove no sweep", "one at least", remedy) for name in idle
    ]


def _missing(missing: tuple[Place, ...]) -> Problem:
    listed = ", ".join(str(place) for place in missing[:8]) + (", ..." if len(missing) > 8 else "")
    return Problem(
        f"{SWEEPS}/",
        "missing",
        f"{len(missing)} of the protocol's sweeps: {listed}",
        "every sweep of protocol.temperatures, directions and levels",
        "flexura import with --allow-missing to go on without",
    )
