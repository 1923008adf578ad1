"""How an acquired campaign ended, and how it left the rig: the record, the closing line and the exit status."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.files.campaign_error import CampaignFileError
from app.files.disk_room import UnwrittenFileError
from drivers.rig.campaign import Outcome
from drivers.rig.errors import RigInterrupted, RigStopped

NOT_GOOD_ENOUGH, NOT_AT_REST, SIGNALLED = 1, 3, 128


@dataclass(frozen=True)
class Ending:
    """Report of a campaign that has ended, completed or broken off.

    Attributes
    ----------
    record : dict
        For JSON.
    line : str
        For people.
    status : int
        0 whole; 1 not; 3 where something could not be verified to be at rest, whatever else; 128 and the signal's
        number.
    """

    record: dict[str, Any]
    line: str
    status: int


def completed(outcome: Outcome, unsafe: tuple[str, ...], folder: Path, seconds: float) -> Ending:
    """Return the ending of a campaign that has nothing left to do.

    Parameters
    ----------
    unsafe : tuple of str
        What is not at rest.
    folder : Path
        Of the campaign.
    seconds : float
        Time that it took, s.
    """
    record = {
        "state": "complete" if not outcome.missing else "complete with sweeps missing",
        "finished": outcome.finished,
        "missing": outcome.missing,
        "made_now": outcome.made_now,
        "doubted": outcome.doubted,
        "unsafe": list(unsafe),
        "seconds": seconds,
    }
    line = f"{outcome.finished} sweeps in {folder}, {outcome.made_now} of them now, in {seconds:.1f} s"
    if outcome.missing:
        line += f"; {outcome.missing} are missing (events.jsonl says why; --again tries once more)"
    if outcome.doubted:
        line += f"; the temperature of {outcome.doubted} is in doubt (events.jsonl says why)"
    status = NOT_AT_REST if unsafe else NOT_GOOD_ENOUGH if outcome.missing else 0
    return Ending(record, line + not_at_rest(unsafe), status)


def broken_off(error: BaseException, unsafe: tuple[str, ...] | None, folder: Path, signal: int) -> Ending:
    """Return the ending of a campaign that was stopped.

    Parameters
    ----------
    error : BaseException
        By which.
    unsafe : tuple of str or None
        What is not at rest; None where the rig was never touched.
    signal : int
        Number of the signal that asked for it; 0 without one.
    """
    why = str(error) or type(error).__name__
    rest = "the drive is at 0 V and the oven at rest"
    line = f"stopped: {why}"
    if isinstance(error, RigInterrupted):
        line = f"stopped{f'; {rest}' if unsafe == () else ''}; run the same command again to continue"
    elif isinstance(error, UnwrittenFileError):
        line = f"stopped: {why}"
    elif isinstance(error, OSError):
        line = f"stopped: {folder} cannot be written: {why}. Make room, then run this again"
    elif not isinstance(error, RigStopped | CampaignFileError):
        why = f"{type(error).__name__}: {error}"
        line = f"stopped by a defect of the program{f'; {rest}' if unsafe == () else ''}: {why}"
    status = NOT_AT_REST if unsafe else SIGNALLED + signal if signal else NOT_GOOD_ENOUGH
    record = {"state": "stopped", "why": why, "unsafe": list(unsafe or ())}
    return Ending(record, line + not_at_rest(unsafe or ()), status)


def not_at_rest(unsafe: tuple[str, ...]) -> str:
    """Return a line for everything that could not be verified to be at rest."""
    return "".join(f"\nNOT AT REST: {what}" for what in unsafe)
