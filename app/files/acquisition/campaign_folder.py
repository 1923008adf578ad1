"""The campaign folder a rig writes into: begun or taken up again, one finished file for every sweep."""

import errno
import logging
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from analysis.experiment import Experiment
from analysis.protocol.protocol import SweepSetPoint
from analysis.recordings.campaign import Sensitivities, Sensitivity, Sweep
from app.files.acquisition import events
from app.files.acquisition.events import LatestRepeat, save_latest
from app.files.acquisition.same_experiment import (
    REJECTED,
    REWIRED,
    changed_keys,
    put_log_aside,
    require_ours,
    rewired,
)
from app.files.atomic import force_folder_to_disk
from app.files.campaign_error import CampaignFileError, Problem
from app.files.campaigns.coverage import Place
from app.files.campaigns.folder import (
    SWEEPS,
    Source,
    file_name,
    read_sweep_file,
    remove_unfinished,
    sweep_paths,
    write_protocol,
    write_sweep,
)
from app.files.campaigns.kind import is_campaign_folder
from app.files.folder_lock import writable
from drivers.ni.cards import Record, go_on

SPARE_DISK = 50_000_000
"""Bytes of disk left free for the log and for whatever else lives there."""


class AcquiredCampaign:
    """A campaign folder open for a rig; made by `open_campaign`.

    Parameters
    ----------
    folder : Path
    experiment : Experiment
    source : Source
        The experiment's file.
    check : callable
        Called between the files that are there; raises to break their verification off.
    sensitivities : Sensitivities, optional
        By which recorded volts become the units that are written; left out where all channels are volts.
    """

    def __init__(
        self,
        folder: Path,
        experiment: Experiment,
        source: Source,
        check: Callable[[], None] = go_on,
        sensitivities: Sensitivities | None = None,
    ) -> None:
        self.folder = folder
        self._sensitivities = sensitivities or _volts(experiment)
        self._sensors = tuple(output.id for output in experiment.outputs)
        self._source = source
        self._finished = self._verified(check)

    def finished(self) -> frozenset[int]:
        """Return the steps whose sweeps are there and whole."""
        return frozenset(self._finished)

    def sweeps(self) -> Iterator[Sweep]:
        """Read the finished sweeps, in the order in which they are asked for; one that is damaged is left out."""
        for path in sweep_paths(self.folder):
            sweep, _ = read_sweep_file(path, f"{SWEEPS}/{path.name}")
            if sweep is not None:
                yield sweep

    def keep(self, sweep: Sweep, set_point: SweepSetPoint, attempt: int) -> None:
        """Write a good sweep.

        Parameters
        ----------
        sweep : Sweep
            In volts, as recorded.

        Raises
        ------
        FileExistsError
            Rather than touch a sweep that is there.
        OSError
            If it cannot be written: a full disk, as a rule.
        """
        path = self.folder / SWEEPS / file_name(sweep, _place(set_point))
        if path.exists():
            raise FileExistsError(errno.EEXIST, "a finished sweep is never overwritten", str(path))
        self._write(path, sweep, {"attempt": attempt})
        self._finished.add(set_point.step)

    def put_aside(self, sweep: Sweep, set_point: SweepSetPoint, attempt: int, faults: Sequence[str]) -> None:
        """Write a bad sweep where no reader of campaigns looks.

        Parameters
        ----------
        sweep : Sweep
            In volts, as recorded.
        faults : sequence of str
            What is wrong with it; written into the file.
        """
        stem = Path(file_name(sweep, _place(set_point))).stem
        path = self.folder / REJECTED / f"{stem}_attempt{attempt}.h5"
        while path.exists():
            path = path.with_name(f"{path.stem}x.h5")
        self._write(path, sweep, {"attempt": attempt, "faults": "\n".join(faults)})

    def show(self, record: Record, set_point: SweepSetPoint, repeat: int) -> None:
        """Put a repeat where windows look; OSError is logged, for nothing hangs on it.

        Parameters
        ----------
        repeat : int
            From 0.
        """
        latest = LatestRepeat(
            step=set_point.step,
            repeat=repeat,
            place=str(set_point),
            channels=("drive", *self._sensors),
            signals=np.vstack([record.drive[None], record.responses]).astype(np.float32),
            overloaded=record.overloaded,
            sample_rate=record.sample_rate,
            full_scale=record.full_scale,
        )
        try:
            save_latest(self.folder, latest)
        except OSError as error:
            logging.getLogger(__name__).warning("a repeat could not be shown: %s", error)

    def log(self, event: Mapping[str, Any]) -> None:
        """Append an event to ``events.jsonl``."""
        events.append_event(self.folder, dict(event))

    def events(self) -> list[dict[str, Any]]:
        """Read every event."""
        return events.read_events(self.folder)

    def _write(self, path: Path, sweep: Sweep, notes: Mapping[str, str | int | float]) -> None:
        needed = sweep.drive.nbytes + sweep.responses.nbytes + SPARE_DISK
        free = shutil.disk_usage(self.folder).free
        if free < needed:
            raise OSError(
                errno.ENOSPC, f"{free / 1e6:.0f} MB are free, {needed / 1e6:.0f} MB are needed", str(path)
            )
        measured, units = self._sensitivities.measured(sweep), self._sensitivities.units
        write_sweep(path, measured, self._sensors, self._source, notes, units)

    def _verified(self, check: Callable[[], None]) -> set[int]:
        """Return the steps of the sweeps that are there; CampaignFileError for one that was damaged since."""
        steps, problems = set(), []
        for path in sweep_paths(self.folder):
            check()
            sweep, wrong = read_sweep_file(path, f"{SWEEPS}/{path.name}")
            if wrong is not None:
                remedy = "move it out of the campaign; the same command then measures it again"
                problems.append(Problem(wrong.file, wrong.key, wrong.seen, wrong.allowed, remedy))
            elif sweep is not None:
                steps.add(sweep.step)
        if problems:
            raise CampaignFileError(self.folder, problems)
        return steps


def open_campaign(
    folder: Path,
    protocol: dict[str, Any],
    experiment: Experiment,
    source: Source,
    check: Callable[[], None] = go_on,
    sensitivities: Sensitivities | None = None,
) -> AcquiredCampaign:
    """Make a campaign folder, or resume one; the caller holds its `folder_lock`.

    Parameters
    ----------
    protocol : dict
        Of `frozen_protocol`. It must be the very one a folder that is there was begun with, unless nothing was
        measured: then that folder's protocol is replaced, and its log put aside.
    check, sensitivities : callable, Sensitivities
        See `AcquiredCampaign`.

    Raises
    ------
    CampaignFileError
        If it holds something else, or cannot be written.
    """
    with writable(folder):
        _prepare(folder, protocol)
        return AcquiredCampaign(folder, experiment, source, check, sensitivities)


def campaign_log(folder: Path) -> Callable[[Mapping[str, Any]], None]:
    """Return what appends an event to the log of a campaign, once there is one in the folder."""
    return events.log_of(folder, is_campaign_folder)


def _prepare(folder: Path, protocol: dict[str, Any]) -> None:
    require_ours(folder, protocol)
    if is_campaign_folder(folder):
        remove_unfinished(folder)
        if changed_keys(folder, protocol):
            put_log_aside(folder)
            write_protocol(folder, protocol)
        elif (wiring := rewired(folder, protocol)) is not None:
            events.append_event(folder, {"event": REWIRED, "wiring": wiring})
    else:
        folder.mkdir(exist_ok=True)
        write_protocol(folder, protocol)
    (folder / SWEEPS).mkdir(exist_ok=True)
    force_folder_to_disk(folder)


def _volts(experiment: Experiment) -> Sensitivities:
    """Return the sensitivities of channels that are all volts; ValueError where one is not."""
    channels = (experiment.inputs[0], *experiment.outputs)
    strangers = [channel.id for channel in channels if channel.unit != "V"]
    if strangers:
        raise ValueError(f"channels {strangers} are not in volts; their sensitivities are needed")
    drive, *responses = (Sensitivity(channel) for channel in channels)
    return Sensitivities(drive, tuple(responses))


def _place(set_point: SweepSetPoint) -> Place:
    return Place(set_point.temperature, set_point.direction, set_point.level)
