"""Health stage: what has changed on a panel since its baseline, computed and saved.

A later date is a campaign folder, or drive and response as files of sound.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from analysis.arrays import Real
from analysis.experiment import Experiment
from analysis.gap.data.compression import Nodes
from analysis.gap.data.preparation import EVERY_LINE, sharpest
from analysis.health.baseline import HealthBaseline, self_check
from analysis.health.candidates import change_candidates
from analysis.health.recording import DatedRecording, played_date, recordings_of
from analysis.health.watch import HealthReport, HealthWatch
from analysis.progress import Progress
from analysis.recordings.frf import Frf, campaign_frf
from analysis.thermometry import Decimator
from analysis.twin_model import Effects
from analysis.updated import Updated
from app.files.atomic import write_json
from app.files.bad_file import ResultFileError, UnsuitedOptionError
from app.files.campaigns.kind import DRIVE, FRF, RESPONSE, declared_date
from app.files.campaigns.loading import load_campaign
from app.files.provenance import provenance, sha256
from app.files.results.best_twin import best_twin
from app.files.results.modes_file import load_frf
from app.files.results.run_folder import run_file
from app.files.results.twin_file import require_same_panel
from app.files.sound_file import Sound, opened_sound
from app.summaries.health import headline, health_record
from app.twins.campaign_twin import campaign_model

HEALTH = "health.json"
FALSE_ALARM_RATE = 1e-3
"""False alarms per date: of a panel that is asked every week, one in twenty years."""
RATES = (1e-9, 0.1)
"""Lowest and highest that may be asked for."""


@dataclass(frozen=True, kw_only=True)
class HealthRequest:
    """Dates that are judged against a baseline, as typed or declared.

    Attributes
    ----------
    baseline : Path
        Run folder of ``flexura update``, of the panel when it was healthy.
    dates : tuple of Path
        Run folders with frf.h5, campaign folders, or folders of sound, in order of time.
    rate : float
        False alarms per date, at most.
    mains : float
        Hz.
    """

    baseline: Path
    dates: tuple[Path, ...]
    rate: float = FALSE_ALARM_RATE
    mains: float = 50.0

    def __post_init__(self) -> None:
        """Raise UnsuitedOptionError for no dates, and a rate outside what is allowed."""
        if not self.dates:
            raise UnsuitedOptionError("no dates; name one or more")
        low, high = RATES
        if not low <= self.rate <= high:
            raise UnsuitedOptionError(
                f"--rate {self.rate:g}: allowed are {low:g} to {high:g} false alarms per date"
            )


@dataclass(frozen=True)
class WatchedPanel:
    """Result of the health stage.

    Attributes
    ----------
    report : HealthReport
    notes : tuple of str
        For people.
    inputs : mapping of str to str
        SHA-256 of everything that was read.
    """

    report: HealthReport
    notes: tuple[str, ...] = ()
    inputs: dict[str, str] = field(default_factory=dict, repr=False)

    def record(self) -> dict[str, Any]:
        """Return what health.json holds, without provenance."""
        return health_record(self.report)

    def __repr__(self) -> str:
        """Say what has changed, in one line."""
        return f"<WatchedPanel: {headline(self.report)}>"


@dataclass(frozen=True)
class LaterDate:
    """FRFs of a date after the baseline.

    Attributes
    ----------
    name : str
        Of its folder.
    experiment : Experiment
    frf : Frf
    declared : str
        Name of the file that declares it.
    inputs : mapping of str to str
        SHA-256 of what was read.
    """

    name: str
    folder: Path
    experiment: Experiment
    frf: Frf
    declared: str
    inputs: dict[str, str]


@dataclass(frozen=True)
class LaterSound:
    """Sound that the panel played on a date after the baseline, and what it answered.

    Attributes
    ----------
    name : str
        Of its folder.
    folder : Path
    inputs : mapping of str to str
        SHA-256 of both files.
    """

    name: str
    folder: Path
    inputs: dict[str, str]


def later_date(folder: Path, mains: float) -> LaterDate | LaterSound:
    """Read a date: a run folder with frf.h5, a campaign folder, whose FRFs are computed, or the names of sound.

    Parameters
    ----------
    mains : float
        Hz.

    Raises
    ------
    ResultFileError, CampaignFileError
        For a folder that is none of them, or cannot be read.
    """
    name = folder.resolve().name
    declared = declared_date(folder)
    if declared == DRIVE:
        return LaterSound(name, folder, {f"{name}/{file}": sha256(folder / file) for file in (DRIVE, RESPONSE)})
    if declared == FRF:
        experiment, frf = load_frf(folder / FRF)
        return LaterDate(name, folder, experiment, frf, FRF, {f"{name}/{FRF}": sha256(folder / FRF)})
    campaign = load_campaign(folder)
    try:
        frf = campaign_frf(campaign, mains=mains)
    except ValueError as error:
        raise ResultFileError(f"{folder}: its FRFs cannot be computed: {error}") from error
    inputs = {f"{name}/{key}": digest for key, digest in campaign.hashes.items()}
    return LaterDate(name, folder, campaign.experiment, frf, declared, inputs)


def compute(request: HealthRequest, report: Progress) -> WatchedPanel:
    """Judge dates in turn against a baseline.

    Parameters
    ----------
    report : callable
        Called with a stage's name and the share of it done.

    Raises
    ------
    ResultFileError, CampaignFileError
        For a baseline that is none, a date of another panel, and whatever cannot be read.
    """
    run = request.baseline
    best = best_twin(run, "health")
    experiment, frf = load_frf(run_file(run, "frf.h5", "health"))
    laws = best.twin.needed_laws
    updated = best.twin.updated
    later = [later_date(one, request.mains) for one in request.dates]
    for one in later:
        if isinstance(one, LaterDate):
            _require_comparable(one, experiment, frf)
    twin, _ = campaign_model(experiment, updated, report, None, None)
    held = {name: {one.name: one.value for one in values} for name, values in best.effects.items()}
    unknown = [name for name in held if name not in twin.cards]
    if unknown:
        raise ResultFileError(
            f"{best.twin.path}: {', '.join(unknown)}: no effect of the library; make a baseline without "
            "effects of your own: flexura update"
        )
    effects: Effects = {**updated.departures, **held}
    nodes = _nodes(frf, updated)
    inputs = len(experiment.inputs)
    patches = tuple(one.id for one in (*experiment.inputs, *experiment.outputs) if one.patch is not None)
    candidates = change_candidates(twin.cards, effects, patches)
    try:
        frf.require_noise()
        first = recordings_of(frf, nodes, frf.excluded, "baseline", inputs)
        report("baseline", 0.0)
        baseline = HealthBaseline.of(
            twin, laws, effects, updated.gains, first, candidates, frf.channels, _sources(experiment)
        )
    except ValueError as error:
        raise ResultFileError(f"{run}: no baseline: {error}") from error
    twins = []
    for number, temperature in enumerate(baseline.temperature):
        report("baseline", number / len(baseline.temperature))
        twins.append(baseline.linearised(float(temperature)))
    report("baseline", 1.0)
    watch = HealthWatch(
        baseline, self_check(baseline, twins), request.rate, baseline, [baseline.completed(one) for one in twins]
    )
    notes = [*best.notes, *same_sweeps(later, frf)]
    for number, one in enumerate(later):
        report("dates", number / len(later))
        if isinstance(one, LaterDate):
            recordings = _recordings(one, nodes, frf.excluded, experiment)
        else:
            recordings = [_played(one, nodes, frf, experiment, updated)]
        notes += _taken(watch, one.name, recordings)
    report("dates", 1.0)
    hashes = {f"baseline {name}": sha256(run / name) for name in ("frf.h5", best.twin.path.name)}
    for one in later:
        hashes |= one.inputs
    return WatchedPanel(watch.report(), tuple(dict.fromkeys(notes)), hashes)


def same_sweeps(later: Sequence[LaterDate | LaterSound], frf: Frf) -> list[str]:
    """Say which dates have sweeps of the baseline, or of an earlier date, which then have not changed."""
    known = {sweep.tobytes(): "the baseline" for sweep in frf.h}
    said = []
    for one in later:
        if not isinstance(one, LaterDate):
            continue
        own = [sweep.tobytes() for sweep in one.frf.h]
        others = dict.fromkeys(known[sweep] for sweep in own if sweep in known)
        if others:
            said.append(f"{one.name}: has sweeps of {' and '.join(others)}: no change of these says nothing")
        known |= {sweep: one.name for sweep in own if sweep not in known}
    return said


def save(run: Path, found: WatchedPanel) -> dict[str, Any]:
    """Write health.json and return what it holds.

    Parameters
    ----------
    run : Path
        Folder for it.

    Raises
    ------
    OSError
        Where it cannot be written.
    """
    made = provenance(found.inputs, {"rate": found.report.rate})
    record = {**found.record(), "notes": list(found.notes), "provenance": made}
    write_json(run / HEALTH, record)
    return record


def _recordings(
    one: LaterDate, nodes: Nodes, excluded: np.ndarray[Any, Any], experiment: Experiment
) -> list[DatedRecording]:
    """Return the recordings of a date; ResultFileError for one that has none."""
    try:
        one.frf.require_noise()
        recordings: list[DatedRecording] = recordings_of(
            one.frf, nodes, excluded, one.name, len(experiment.inputs)
        )
    except ValueError as error:
        raise ResultFileError(f"{one.folder}: cannot be judged: {error}") from error
    if not recordings:
        raise ResultFileError(
            f"{one.folder}: at no temperature every input drove ({', '.join(_sources(experiment))}); record "
            "a sweep of each"
        )
    return recordings


def _played(one: LaterSound, nodes: Nodes, frf: Frf, experiment: Experiment, updated: Updated) -> DatedRecording:
    """Return the recording of sound; ResultFileError for sound that says nothing of the panel."""
    lines = frf.frequency
    half_width = 0.5 * float(lines[~frf.excluded][0]) * sharpest(updated.sharpest)
    drives, responses, rate = played_signals(
        one.folder / DRIVE, one.folder / RESPONSE, _sources(experiment), frf.channels, float(lines[-1])
    )
    try:
        return played_date(drives, responses, rate, lines, frf.excluded, nodes, half_width, one.name)
    except ValueError as error:
        raise ResultFileError(f"{one.folder}: cannot be judged: {error}") from error


def _taken(watch: HealthWatch, name: str, recordings: Sequence[DatedRecording]) -> list[str]:
    """Judge a date, and return what is to be said of it."""
    date = watch.take(recordings)
    if date.skipped:
        return [f"{name}: not judged: {date.skipped}"]
    if date.label is not None and abs(date.temperature - date.label) > LABEL_OFF:
        return [
            f"{name}: recorded as {date.label:.1f} °C, the panel itself says {date.temperature:.1f}: its own "
            "is taken; a sensor in the air, or a changed material, makes such a difference"
        ]
    return []


LABEL_OFF = 5.0
"""K between recorded temperature and the panel's own from which it is said: sensors in the air differ by less."""


def _require_comparable(later: LaterDate, experiment: Experiment, frf: Frf) -> None:
    """Raise unless a date is of the baseline's panel, recorded over the same lines."""
    require_same_panel(later.folder, later.declared, later.experiment, experiment)
    ours, theirs = later.frf.frequency, frf.frequency
    if ours.shape != theirs.shape or not np.allclose(ours, theirs, rtol=1e-9):
        raise ResultFileError(
            f"{later.folder}: {len(ours)} lines from {ours[0]:g} to {ours[-1]:g} Hz; allowed: those of the "
            f"baseline, {len(theirs)} from {theirs[0]:g} to {theirs[-1]:g} Hz; record with the same [protocol]"
        )


def _sources(experiment: Experiment) -> tuple[str, ...]:
    return tuple(one.id for one in experiment.inputs)


def _nodes(frf: Frf, updated: Updated) -> Nodes:
    """Nodes of splines for the sharpest resonance of the baseline."""
    used, spacing = frf.frequency[~frf.excluded], float(np.median(np.diff(frf.frequency)))
    try:
        return Nodes.over(used, sharpest(updated.sharpest), spacing=spacing)
    except ValueError:  # too few lines for splines: each line is a node
        return Nodes.over(used, EVERY_LINE, spacing=spacing)


SAMPLES_AT_ONCE = 65_536
"""Samples read and filtered at a time."""


def played_signals(
    drive: Path, response: Path, inputs: tuple[str, ...], outputs: tuple[str, ...], highest: float
) -> tuple[Real, Real, float]:
    """Read two files that were recorded together, at the sample rate that the band needs.

    Parameters
    ----------
    inputs, outputs : tuple of str
        Names of the I inputs and K outputs of the baseline: a channel each, in this order.
    highest : float
        Of the band, Hz.

    Returns
    -------
    drives, responses : (I, n) and (K, n) ndarray
        In the units of the files.
    rate : float
        Hz.

    Raises
    ------
    ResultFileError
        For files that cannot be read, are not of this panel, or do not belong together.
    """
    with opened_sound(drive) as played, opened_sound(response) as measured:
        _require_of_panel(played, inputs, "inputs")
        _require_of_panel(measured, outputs, "outputs")
        if (played.sample_rate, played.frames) != (measured.sample_rate, measured.frames):
            raise ResultFileError(
                f"{response}: {measured.frames} samples at {measured.sample_rate} Hz; those of {drive.name} are "
                f"{played.frames} at {played.sample_rate} Hz: record both together"
            )
        if played.sample_rate < 2.0 * highest:
            raise ResultFileError(
                f"{drive}: sampled at {played.sample_rate} Hz; allowed: from {2.0 * highest:.0f} Hz, twice the "
                "highest line of the baseline"
            )
        down = Decimator(len(inputs) + len(outputs), played.sample_rate, highest)
        blocks = zip(played.blocks(SAMPLES_AT_ONCE), measured.blocks(SAMPLES_AT_ONCE), strict=True)
        every = np.hstack([down.take(np.vstack(pair)) for pair in blocks])
    return every[: len(inputs)], every[len(inputs) :], down.rate


def _require_of_panel(sound: Sound, names: tuple[str, ...], what: str) -> None:
    if sound.channels != len(names):
        raise ResultFileError(
            f"{sound.path}: {sound.channels} channels; the baseline has {len(names)} {what}: {', '.join(names)}, "
            "a channel each, in this order"
        )
