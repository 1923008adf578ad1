"""A hammer test on the error stream, to be heard as well as seen: whoever holds the hammer looks at the plate.

Single keys are taken without waiting for them.
"""

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress

import click

from analysis.declaration.strict import Point
from drivers.hammer.campaign import AskedHit, Key, ToldHit, no_key

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
