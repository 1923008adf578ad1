"""Checks of this computer before a campaign: cards, ports, oven, disk, clock.

Checks before a campaign: state of the rig, and one short sweep.
"""

import os
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from pathlib import Path

from analysis.protocol.acceptance import DURATION, InputLevels
from analysis.protocol.objections import unseen_lag
from app.files.acquisition.campaign_folder import SPARE_DISK
from app.files.acquisition.hammer_folder import HITS
from app.files.bad_file import ResultFileError
from app.files.campaign_error import CampaignFileError, Problem
from app.files.campaigns.folder import sweep_paths
from app.files.campaigns.kind import is_campaign_folder
from app.files.declarations.experiment import AcquiredExperiment, RigKind
from app.files.declarations.hammer_experiment import HammerExperiment
from app.rig.assembly import rig_places
from app.summaries.numbers import duration
from drivers.interruptions import held_back
from drivers.ni.cards import DaqError
from drivers.ni.wiring import InputWiring, Wiring
from drivers.rig.occupancy import RigInUse, in_use, occupied
from drivers.rig.rig import Rig
from drivers.rig.session import rest_drive
from drivers.rig.shot import Shot, fire
from drivers.rig.survey import (
    Finding,
    FindingState,
    look_at_cards,
    look_at_oven,
    look_at_ports,
    look_at_sound,
    serial_ports,
)
from drivers.soundcard.card import SoundCard

EARLIEST = datetime(2025, 1, 1, tzinfo=UTC)
"""A clock that shows less was never set."""
LARGEST_CLOCK_DIFFERENCE = 2.0
"""Largest difference between the computer's and the disk's time, s."""
OF_HIT = 40_000
"""Bytes of a hit beside its samples: an HDF5 file's own, with where it comes from, and what names the hit."""
ENOUGH_BYTES = 1e9
"""Bytes that are enough where no experiment says how many are needed."""


def examine(experiment: AcquiredExperiment | HammerExperiment | None, folder: Path) -> Iterator[Finding]:
    """Yield a finding for everything looked at.

    Parameters
    ----------
    experiment : AcquiredExperiment or HammerExperiment, optional
        Whose cards, oven and amount of data are looked at too.
    folder : Path
        Where a campaign would be written.
    """
    real = experiment is not None and experiment.rig != "simulated"
    cards = experiment.cards if experiment is not None else None
    if cards is None or isinstance(cards, InputWiring):
        yield from look_at_cards(cards, needed=real)
    elif isinstance(cards, SoundCard):
        yield look_at_sound(cards, needed=real)
    yield from look_at_ports()
    if experiment is not None:
        holder = in_use(rig_places(experiment, experiment.rig))
        if holder is not None:
            yield Finding("rig", FindingState.BAD, holder, "wait for its end; nothing was asked of the oven")
        elif experiment.oven is not None:
            yield look_at_oven(experiment.oven, needed=real)
        yield Finding("campaign", FindingState.GOOD, _amount(experiment))
        if isinstance(experiment, AcquiredExperiment):
            recorded = experiment.recorded(experiment.sample_rate)
            for sentence in () if experiment.plate_measured else unseen_lag(recorded):
                yield Finding("temperature of the plate", FindingState.NOTE, sentence)
    yield look_at_disk(experiment, folder)
    yield _clock(folder)


def _amount(experiment: AcquiredExperiment | HammerExperiment) -> str:
    """Say how much is to be measured."""
    if isinstance(experiment, HammerExperiment):
        points, hits = len(experiment.mallet.places), experiment.hammer.hits
        at = f"at {len(experiment.temperatures)} temperatures, " if experiment.oven is not None else ""
        return f"{at}{points} point{'s' * (points > 1)}, {hits} hit{'s' * (hits > 1)} each"
    seconds = experiment.protocol.seconds(experiment.oven.room_temperature)
    return f"{experiment.protocol.count} sweeps, about {duration(seconds)}"


def _hit_bytes(experiment: HammerExperiment) -> float:
    """Return the size of a hit's file with its declarations and its line of the log, bytes."""
    samples = experiment.hammer.duration * experiment.cards.sample_rate
    return 4.0 * samples * (1 + len(experiment.cards.responses)) + OF_HIT


def sweep_bytes(experiment: AcquiredExperiment) -> float:
    """Return the size of a finished sweep, bytes."""
    samples = experiment.sweep.record * experiment.sample_rate * experiment.sweep.repeats
    return 4.0 * samples * (1 + len(experiment.cards.responses))


def require_room(experiment: AcquiredExperiment | HammerExperiment, folder: Path) -> None:
    """Raise CampaignFileError where the sweeps or hits that a campaign still lacks cannot all be written."""
    there = _nearest(folder)
    if not there.is_dir():
        raise CampaignFileError(folder, [Problem("", "", f"{there} is a file", "a folder", "use --out")])
    free, (needed, what) = shutil.disk_usage(there).free, _needed(experiment, folder)
    if free < needed:
        seen = f"{free / 1e6:.0f} MB free at {there}"
        allowed = f"{needed / 1e6:.0f} MB {what}"
        raise CampaignFileError(folder, [Problem("", "", seen, allowed, "make room, or use --out")])


def require_port(experiment: AcquiredExperiment | HammerExperiment, file: Path) -> None:
    """Refuse an oven whose serial port does not exist, before anything is opened; for a first start only.

    Nothing was asked of the rig then, and nothing has to be brought to rest. A rig that a killed campaign may have
    left on is another matter: it must be reached, or people told.

    Raises
    ------
    ResultFileError
        With the ports that there are.
    """
    place = experiment.oven.place if experiment.oven is not None else ""
    if place in ("", "simulated") or "://" in place or Path(place).exists():
        return
    ports = [str(port.device) for port in serial_ports()]
    if place.upper() not in (port.upper() for port in ports):
        raise ResultFileError(
            f"{file}: oven.port = {place!r}: this computer has no such port; there are: "
            f"{', '.join(ports) or 'none'} (flexura doctor lists them). Nothing was asked of oven or cards"
        )


def _needed(experiment: AcquiredExperiment | HammerExperiment, folder: Path) -> tuple[float, str]:
    """Return the bytes that a campaign still needs, as doctor and acquire both say it, and what for."""
    if isinstance(experiment, HammerExperiment):
        wanted = len(experiment.mallet.places) * experiment.hammer.hits * len(experiment.temperatures)
        left = max(wanted - len(list((folder / HITS).glob("*.h5"))), 0)
        size, what = _hit_bytes(experiment), f"for the {left} hits to be made"
    else:
        left = experiment.protocol.count - (len(sweep_paths(folder)) if is_campaign_folder(folder) else 0)
        size, what = sweep_bytes(experiment), f"for the {left} sweeps to be made"
    return left * size + (SPARE_DISK if left else 0.0), what


def _nearest(folder: Path) -> Path:
    """Return the folder, or the nearest of those it would be made in that is there."""
    return next(parent for parent in (folder, *folder.parents) if parent.exists())


def look_at_disk(experiment: AcquiredExperiment | HammerExperiment | None, folder: Path) -> Finding:
    """Look whether a folder's disk has room for an experiment's campaign."""
    there = _nearest(folder)
    free = shutil.disk_usage(there).free
    if experiment is None:
        needed = ENOUGH_BYTES
        what = "are enough for most campaigns; flexura doctor EXPERIMENT.toml says what yours needs"
    else:
        needed, words = _needed(experiment, folder)
        what = f"needed {words}"
    seen = f"{free / 1e6:.0f} MB free at {there}, {needed / 1e6:.0f} MB {what}"
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
    if apart > LARGEST_CLOCK_DIFFERENCE:
        step = "let both be kept by the same time server"
        return Finding(
            "clock", FindingState.NOTE, f"{local}, {apart:.0f} s from that of the disk at {there}", step
        )
    return Finding("clock", FindingState.GOOD, local)


LARGEST_RANGE_SHARE = 0.5
"""Share of an input's range that a short sweep may fill: a long one brings resonances up further."""
LARGEST_HUM_SHARE = 0.03
"""Share of a sensor's level that hum may have."""
CHECK = "check this cable, its terminal in [cards] and, for a drive, the amplifier's input"


def look_before(experiment: AcquiredExperiment, kind: RigKind, folder: Path) -> Iterator[Finding]:
    """Check cards, oven, length of the campaign and disk, before anything is played.

    Parameters
    ----------
    kind : str
        Of the rig.
    folder : Path
        Of the campaign.
    """
    if (holder := in_use(rig_places(experiment, kind))) is not None:
        yield Finding("rig", FindingState.BAD, holder, "wait for its end; nothing was asked of it")
    elif kind != "simulated":
        if isinstance(experiment.cards, Wiring):
            yield from look_at_cards(experiment.cards, needed=True)
        elif isinstance(experiment.cards, SoundCard):
            yield look_at_sound(experiment.cards, needed=True)
        yield look_at_oven(experiment.oven, needed=True)
    seconds = experiment.protocol.seconds(experiment.oven.room_temperature)
    yield Finding("campaign", FindingState.GOOD, f"{experiment.protocol.count} sweeps, about {duration(seconds)}")
    yield look_at_disk(experiment, folder)


def shoot(
    experiment: AcquiredExperiment, kind: RigKind, rig: Rig, check: Callable[[], None]
) -> tuple[list[Finding], tuple[str, ...]]:
    """Play one short sweep and judge every input.

    Parameters
    ----------
    kind : str
        Of the rig.
    check : callable
        Raises where the end of the program is asked for.

    Returns
    -------
    findings : list of Finding
        One per input, or the faults of the shot.
    unsafe : tuple of str
        Outputs that could not be verified to be at 0 V.

    Raises
    ------
    BaseException
        What is no fault of the rig, once the drive is at rest.
    """
    cards, shot, raised = None, Shot(()), None
    try:
        with occupied(rig_places(experiment, kind), "flexura acquire --test-shot"):
            try:
                cards = rig.open_cards()
                shot = fire(cards, experiment.protocol, check)
            except BaseException as error:  # noqa: BLE001 (whatever it is, the drive has to come to rest)
                raised = error
            with held_back():
                unsafe = rest_drive(rig.open_cards, cards)
    except RigInUse as error:
        return [Finding("rig", FindingState.BAD, error.what, error.next_step)], ()
    if isinstance(raised, DaqError):
        found = [Finding("shot", FindingState.BAD, raised.said, raised.next_step)]
    elif raised is not None:
        if unsafe is None:
            raise raised
        found = [Finding("shot", FindingState.BAD, f"{type(raised).__name__}: {raised}")]
    else:
        names = ["drive", *(output.id for output in experiment.recorded(experiment.sample_rate).outputs)]
        found = [Finding("shot", FindingState.BAD, fault, CHECK) for fault in shot.faults]
        found += [_channel(name, one, experiment) for name, one in zip(names, shot.inputs, strict=False)]
    return found, () if unsafe is None else (unsafe,)


def _channel(name: str, one: InputLevels, experiment: AcquiredExperiment) -> Finding:
    seen = (
        f"{1e3 * one.level:.3g} mV rms, peak at {100 * one.peak:.0f} % of the range, "
        f"coherence {one.coherence:.3f}, noise {1e3 * one.noise:.2g} mV rms, "
        f"of it {1e3 * one.hum:.2g} mV hum of {one.mains:.0f} Hz"
    )
    limits, levels = experiment.limits, experiment.sweep.levels
    lowest = one.level * min(levels) / max(levels)
    steps = []
    if one.peak > LARGEST_RANGE_SHARE:
        steps.append("lower the level or widen cards.input_range: longer sweeps bring resonances up further")
    if name != "drive" and lowest < limits.silence:
        steps.append(f"at {min(levels):g} V it would count as silent (limits.silence {limits.silence:g} V)")
    if name != "drive" and one.hum > LARGEST_HUM_SHARE * lowest:
        steps.append("look for a ground loop or an open shield")
    if one.coherence < limits.coherence:
        steps.append(
            f"a sweep of {experiment.sweep.duration:g} s may do better than {DURATION:g} s; else raise the level"
        )
    return Finding(f"input of {name}", FindingState.NOTE if steps else FindingState.GOOD, seen, "; ".join(steps))
