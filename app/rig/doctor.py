"""Checks of this computer before a campaign: cards, ports, oven, disk, clock."""

import os
import shutil
import tempfile
import time
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

from app.files.acquired_campaign import SPARE
from app.files.campaign_error import CampaignFileError, Problem
from app.files.campaign_folder import sweep_paths
from app.files.campaign_kind import is_campaign_folder
from app.files.experiment_toml import AcquiredExperiment
from app.rig.assembly import rig_places
from app.terminal.campaign_progress import duration
from drivers.ni.wiring import Wiring
from drivers.rig.occupancy import in_use
from drivers.rig.survey import Finding, FindingState, look_at_cards, look_at_oven, look_at_ports, look_at_sound
from drivers.soundcard.settings import SoundCard

EARLIEST = datetime(2025, 1, 1, tzinfo=UTC)
"""A clock that shows less was never set."""
APART = 2.0
"""Largest difference between the computer's and the disk's time, s."""
PLENTY = 1e9
"""Bytes that are enough where no experiment says how many are needed."""


def examine(experiment: AcquiredExperiment | None, folder: Path) -> Iterator[Finding]:
    """Yield a finding for everything looked at.

    Parameters
    ----------
    experiment : AcquiredExperiment, optional
        Whose cards, oven and amount of data are looked at too.
    folder : Path
        Where a campaign would be written.
    """
    real = experiment is not None and experiment.rig != "simulated"
    cards = experiment.cards if experiment is not None else None
    if cards is None or isinstance(cards, Wiring):
        yield from look_at_cards(cards, needed=real)
    elif isinstance(cards, SoundCard):
        yield look_at_sound(cards, needed=real)
    yield from look_at_ports()
    if experiment is not None:
        holder = in_use(rig_places(experiment, experiment.rig))
        if holder is not None:
            yield Finding("rig", FindingState.BAD, holder, "wait for its end; nothing was asked of the oven")
        else:
            yield look_at_oven(experiment.oven, needed=real)
        seconds = experiment.protocol.seconds(experiment.oven.room_temperature)
        yield Finding(
            "campaign", FindingState.GOOD, f"{experiment.protocol.count} sweeps, about {duration(seconds)}"
        )
    yield look_at_disk(experiment, folder)
    yield _clock(folder)


def campaign_bytes(experiment: AcquiredExperiment) -> float:
    """Estimate the size of a campaign whose every sweep needs one repetition, bytes."""
    return 2.0 * sweep_bytes(experiment) * experiment.protocol.count


def sweep_bytes(experiment: AcquiredExperiment) -> float:
    """Return the size of a finished sweep, bytes."""
    samples = experiment.sweep.record * experiment.sample_rate * experiment.sweep.repeats
    return 4.0 * samples * (1 + len(experiment.cards.responses))


def require_room(experiment: AcquiredExperiment, folder: Path) -> None:
    """Raise CampaignFileError where the sweeps that a campaign still lacks cannot all be written."""
    there = _nearest(folder)
    if not there.is_dir():
        raise CampaignFileError(folder, [Problem("", "", f"{there} is a file", "a folder", "use --out")])
    left = experiment.protocol.count - (len(sweep_paths(folder)) if is_campaign_folder(folder) else 0)
    free, needed = shutil.disk_usage(there).free, left * sweep_bytes(experiment) + (SPARE if left else 0.0)
    if free < needed:
        seen = f"{free / 1e6:.0f} MB free at {there}"
        allowed = f"{needed / 1e6:.0f} MB for the {left} sweeps to be made"
        raise CampaignFileError(folder, [Problem("", "", seen, allowed, "make room, or use --out")])


def _nearest(folder: Path) -> Path:
    """Return the folder, or the nearest of those it would be made in that is there."""
    return next(parent for parent in (folder, *folder.parents) if parent.exists())


def look_at_disk(experiment: AcquiredExperiment | None, folder: Path) -> Finding:
    """Look whether a folder's disk has room for an experiment's campaign."""
    there = _nearest(folder)
    free = shutil.disk_usage(there).free
    needed = PLENTY if experiment is None else 1e8 + campaign_bytes(experiment)
    seen = f"{free / 1e9:.1f} GB free at {there}, {needed / 1e9:.2f} GB wanted"
    if not there.is_dir():
        return Finding("disk", FindingState.BAD, f"{there} is a file", "choose another folder with --out")
    if not os.access(there, os.W_OK):
        return Finding("disk", FindingState.BAD, f"{there} cannot be written", "choose another folder with --out")
    if free < needed:
        return Finding("disk", FindingState.BAD, seen, "make room, or choose another disk with --out")
    return Finding("disk", FindingState.GOOD, seen)


def _clock(folder: Path) -> Finding:
    """Look at the time of day: no deadline hangs on it, but a wrong date in a measurement stays wrong."""
    now = datetime.now(UTC)
    local = now.astimezone().isoformat(timespec="seconds")
    if now < EARLIEST:
        return Finding("clock", FindingState.BAD, f"shows {local}", "set it, and let it be kept by a time server")
    there = _nearest(folder)
    try:
        with tempfile.NamedTemporaryFile(dir=there) as probe:
            apart = abs(Path(probe.name).stat().st_mtime - time.time())
    except OSError:  # reported already, as a disk that cannot be written
        apart = 0.0
    if apart > APART:
        step = "let both be kept by the same time server"
        return Finding(
            "clock", FindingState.NOTE, f"{local}, {apart:.0f} s from that of the disk at {there}", step
        )
    return Finding("clock", FindingState.GOOD, local)
