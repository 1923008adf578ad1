"""Checks before a campaign: state of the rig, and one short sweep."""

from collections.abc import Callable, Iterator
from pathlib import Path

from analysis.protocol.acceptance import DURATION, InputLevels
from app.files.declarations.experiment import AcquiredExperiment, RigKind
from app.rig.assembly import rig_places
from app.rig.doctor import look_at_disk
from app.summaries.numbers import duration
from drivers.interruptions import held_back
from drivers.ni.errors import DaqError
from drivers.ni.wiring import Wiring
from drivers.rig.occupancy import RigInUse, in_use, occupied
from drivers.rig.rest import rest_drive
from drivers.rig.rig import Rig
from drivers.rig.shot import Shot, fire
from drivers.rig.survey import Finding, FindingState, look_at_cards, look_at_oven, look_at_sound
from drivers.soundcard.settings import SoundCard

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
