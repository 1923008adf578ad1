"""How an acquired campaign ended, and how it left the rig: the record, the closing line and the exit status.

A running campaign on the error stream: a bar with the time left, or plain lines where it is no terminal.

A hammer test on the error stream, to be heard as well as seen: whoever holds the hammer looks at the plate.

Single keys are taken without waiting for them.
"""

import errno
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

import click
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

from analysis.declaration.strict import Point
from app.files.campaign_error import CampaignFileError
from app.files.disk_room import FULL, REFUSALS, UnwrittenFileError
from app.summaries.numbers import duration
from drivers.hammer.campaign import AskedHit, Key, ToldHit, no_key
from drivers.rig.campaign import Moment, Observer, Outcome
from drivers.rig.end_requests import RigInterrupted, RigStopped

NOT_GOOD_ENOUGH, NOT_AT_REST, SIGNALLED = 1, 3, 128
NO_ROOM = FULL - {errno.EFBIG}
GONE = frozenset({errno.ENOENT, errno.ENOTDIR, errno.ENODEV, errno.ENXIO, getattr(errno, "ESTALE", errno.ENOENT)})
"""The folder is not there, or the disk or share that holds it."""


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
    rest = "; the drive is at 0 V and the oven at rest" if unsafe == () else ""
    line = f"stopped: {why}"
    if isinstance(error, RigInterrupted):
        line = f"stopped{rest}; run the same command again to continue"
    elif isinstance(error, OSError):
        why = _refused(error, folder)
        line = f"stopped{rest}: {why}"
    elif not isinstance(error, RigStopped | CampaignFileError):
        why = f"{type(error).__name__}: {error}"
        line = f"stopped by a defect of the program{rest}: {why}"
    status = NOT_AT_REST if unsafe else SIGNALLED + signal if signal else NOT_GOOD_ENOUGH
    record = {"state": "stopped", "why": why, "unsafe": list(unsafe or ())}
    return Ending(record, line + not_at_rest(unsafe or ()), status)


def _refused(error: OSError, folder: Path) -> str:
    """Say what the system refused a campaign, and what to do: room helps where it is missing, and nowhere else."""
    named, why = error.filename or folder, error.strerror or str(error)
    if error.errno in GONE and not _is_there(folder):
        return f"{folder} has gone; put it back, or name another with --out, then run this again"
    if error.errno == errno.ENAMETOOLONG:
        return f"{named}: the name is too long for this disk; name a shorter one with --out, then run this again"
    if isinstance(error, UnwrittenFileError):
        return str(error)
    if error.filename is None and error.errno not in REFUSALS:  # of an instrument or a network, not of the disk
        return f"{why}; run the same command again to continue"
    said = f"{folder} cannot be written: {why}"
    if error.filename is not None:
        said += f" ({named})"
    if error.errno in NO_ROOM:
        return f"{said}. Make room, then run this again"
    return f"{said}. See to its permissions and the disk, or name another with --out, then run this again"


def _is_there(folder: Path) -> bool:
    with suppress(OSError):  # a disk that has gone with it, or a name that no disk takes
        return folder.is_dir()
    return False


def not_at_rest(unsafe: tuple[str, ...]) -> str:
    """Return a line for everything that could not be verified to be at rest."""
    return "".join(f"\nNOT AT REST: {what}" for what in unsafe)


@contextmanager
def campaign_screen(clock_is_virtual: bool, *, shown: bool = True) -> Iterator[Observer]:
    """Yield an observer that shows every moment of a campaign.

    Parameters
    ----------
    clock_is_virtual : bool
        The time left is that of a simulated rig, which passes faster than ours.
    shown : bool
        False: an observer that prints nothing.
    """
    console = Console(stderr=True, quiet=not shown)
    columns = (
        TextColumn("{task.description:<16}"),
        TextColumn("{task.fields[temperature]:>6.2f} °C"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[left]}"),
    )
    suffix = " of simulated time" if clock_is_virtual else ""
    with Progress(*columns, console=console, disable=not (shown and console.is_terminal)) as bars:
        bar = bars.add_task("opening", total=None, temperature=0.0, left="")
        last = -1

        def show(moment: Moment) -> None:
            nonlocal last
            left = f"{duration(moment.seconds_left)} left{suffix}"
            lost = f"{moment.given_up} given up, " if moment.given_up else ""
            bars.update(
                bar,
                description=moment.stage,
                completed=moment.done,
                total=moment.total,
                temperature=moment.temperature,
                left=lost + left,
            )
            if not console.is_terminal and moment.done != last:
                last = moment.done
                now = datetime.now().astimezone().strftime("%Y-%m-%d %H:%M:%S %z")  # this goes into a log
                console.print(
                    f"{now} {moment.done} of {moment.total} sweeps, {moment.stage}, {moment.temperature:.2f} °C, "
                    f"{lost}{left}",
                    soft_wrap=True,
                )

        yield show


BELL = "\a"
KEYS = "u: undo the last hit, s: skip this point, r: repeat it from its first hit, q: stop"


class HammerScreen:
    """Prompts for hits, and says of each at once whether it counts: a line, a colour, and the bell.

    One stroke of the bell for a hit that counts, two for one that does not. Where the stream is no terminal, lines
    have neither.

    Parameters
    ----------
    places : sequence of (float, float)
        Of the points, m.
    shown : bool
        False: nothing is printed.
    keys : bool
        Whether keys are heard, so that they are named.
    """

    def __init__(self, places: Sequence[Point], *, shown: bool, keys: bool) -> None:
        self._places = places
        self._shown = shown
        self._terminal = sys.stderr.isatty()
        self._last: tuple[int, int] | None = None
        if keys:
            self._say(KEYS)

    def asked(self, hit: AskedHit) -> None:
        """Show which hit is to be made; in a log only where the point is another one."""
        here = (hit.set_point, hit.point)
        if self._terminal or here != self._last:
            x, y = self._places[hit.point]
            self._say(
                f"Point {hit.point + 1} of {hit.points} ({x:.3f}, {y:.3f}) m: hit {hit.number} of {hit.wanted}",
                bold=True,
            )
        self._last = here

    def told(self, hit: ToldHit) -> None:
        """Say what came of a hit."""
        if hit.rejected:
            self._say(f"  rejected, {hit.peak:.1f} N: {hit.rejected}", colour="red", bells=2)
            return
        known = "" if hit.coherence is None else f", coherence {hit.coherence:.3f}"
        self._say(f"  hit {hit.asked.number} accepted, {hit.peak:.1f} N{known}", colour="green", bells=1)
        if hit.doubt:
            self._say(f"  its temperature is in doubt: {hit.doubt}", colour="yellow")

    def said(self, line: str) -> None:
        """Say what a key has done."""
        self._say(f"  {line}", colour="yellow")

    def _say(self, line: str, colour: str | None = None, bells: int = 0, *, bold: bool = False) -> None:
        if self._shown:
            click.echo(
                click.style(line, fg=colour, bold=bold) + (BELL * bells if self._terminal else ""), err=True
            )


MEANING: dict[str, Key] = {"u": "undo", "s": "skip", "r": "repeat", "q": "stop"}


@contextmanager
def hammer_keys() -> Iterator[Callable[[], Key | None]]:
    """Yield what returns a key typed since it was called last, None where none was, or nobody can type.

    On a terminal, what is typed is neither shown nor held back until the end of a line; the terminal is as it was
    when the block ends. Ctrl-C stays what it is. A terminal that has gone, or that belongs to another program now,
    gives no key.
    """
    if not sys.stdin or not sys.stdin.isatty():
        yield no_key
        return
    if sys.platform == "win32":
        import msvcrt

        def pressed() -> Key | None:
            return MEANING.get(msvcrt.getwch().lower()) if msvcrt.kbhit() else None

        yield pressed
        return
    import os
    import select
    import termios
    import tty

    number = sys.stdin.fileno()
    try:
        before = termios.tcgetattr(number)
        tty.setcbreak(number)
    except termios.error:
        yield no_key
        return

    def typed() -> Key | None:
        try:
            if not select.select([number], [], [], 0.0)[0]:
                return None
            return MEANING.get(os.read(number, 1).decode(errors="replace").lower())
        except (
            OSError
        ):  # EIO: a closed terminal must not end a test, nor must one of which this is in the background
            return None

    try:
        yield typed
    finally:
        with suppress(termios.error):
            termios.tcsetattr(number, termios.TCSADRAIN, before)
