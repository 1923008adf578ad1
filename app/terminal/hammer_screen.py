"""A hammer test on the error stream, to be heard as well as seen: whoever holds the hammer looks at the plate."""

import sys
from collections.abc import Sequence

import click

from analysis.declared import Point
from drivers.hammer.campaign import AskedHit, ToldHit

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
