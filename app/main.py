"""The command line: one verb per stage."""

import difflib
import os
import re
import sys
from collections.abc import Sequence
from importlib import import_module

import click
from threadpoolctl import threadpool_limits

from analysis import __version__
from app.terminal.end_signals import end_signals
from app.terminal.streams import BROKEN, lasting_streams, lost

VERBS = {
    "acquire": "acquire",
    "safe": "safe",
    "new": "new",
    "run": "run",
    "import": "import_campaign",
    "identify": "identify",
    "update": "update",
    "gap": "gap",
    "blind-trial": "blind_trial",
    "focus": "focus",
    "compensate": "compensate",
    "radiation": "radiation",
    "export": "export",
    "render": "render",
    "thermometer": "thermometer",
    "health": "health",
    "study": "study",
    "report": "report",
    "view": "view",
    "watch": "watch",
    "status": "status",
    "doctor": "doctor",
    "check-instrument": "check_instrument",
    "simulate-daq": "simulate_daq",
    "demo": "demo",
    "examples": "examples",
    "completion": "completion",
}


class Verbs(click.Group):
    """Loads the module of a verb when the verb is asked for: no verb waits for the imports of the others."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Verbs in the order of the work."""
        return list(VERBS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return the command of one verb, or None for a word that is none."""
        if cmd_name not in VERBS:
            return None
        command: click.Command = import_module(f"app.commands.{VERBS[cmd_name]}").command
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Name the nearest verb where a word is none; click would have to load all of them for that."""
        close = difflib.get_close_matches(args[0], VERBS, 1)
        if close and args[0] not in VERBS and not ctx.resilient_parsing:
            ctx.fail(f"No such command {args[0]!r}. Did you mean {close[0]!r}?")
        return super().resolve_command(ctx, args)


@click.group(cls=Verbs, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__)
def flexura() -> None:
    """Temperature-aware modal analysis and wave focusing for plate-like structures.

    Verbs stand in the order of the work. Results go to the output stream and into files, all else to the error
    stream. Exit status 0: done, 1: ran, but not good enough, 2: bad input, or a disk that does not take results,
    3: a rig not known to be at rest.
    """


def main(arguments: Sequence[str] | None = None) -> None:
    """Run one verb; exit 0 (done), 1 (not good enough), 2 (bad input) or 3 (a rig not known to be at rest).

    Also 2: results that the disk does not take; 128 and the number of the signal that ended it. Output that nobody
    takes changes none of them, but for a result on stdout that a full disk does not take: 1 in place of 0.
    """
    lasting_streams()
    for pool in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        # Read by libraries the verbs import later, which no limit set now would reach. Their matrices are
        # small: two threads waiting for each other on a busy machine take twenty times as long as one. A
        # cluster sets another number for all programs; it was not meant for these matrices.
        os.environ[pool] = "1"
    with threadpool_limits(1), end_signals() as ends:  # and for those that are loaded already
        try:
            color = False if os.environ.get("NO_COLOR") else None  # None: where there is a terminal
            status = flexura.main(arguments, prog_name="flexura", standalone_mode=False, color=color)
        except click.ClickException as error:
            error.show()
            typed = sys.argv[1:] if arguments is None else arguments
            for line in (*_decimal_comma(error.message, typed), *_leading_dash(error, typed)):
                click.echo(line, err=True)
            sys.exit(2)
        except (click.Abort, KeyboardInterrupt):
            ends.over = True
            click.echo("stopped", err=True)
            sys.exit(ends.status)
    sys.exit(_of_output(status if isinstance(status, int) else 0))


DECIMAL_COMMA = r"(?<![\w.,])[+-]?(?:\d+,(?P<parts>\d+)|,\d+)(?![\w.,])"


def _decimal_comma(message: str, arguments: Sequence[str]) -> list[str]:
    """Say how a refused number with a decimal comma is written; with three digits it may be one of thousands."""
    for found in (one for typed in arguments for one in re.finditer(DECIMAL_COMMA, typed)):
        number, parts = found[0], found["parts"] or ""
        if number in message:
            thousands = f" (or {number.replace(',', '')}, if that is meant)" if len(parts) == 3 else ""
            return [f"Write {number.replace(',', '.')}{thousands}, with a point."]
    return []


def _leading_dash(error: click.ClickException, arguments: Sequence[str]) -> list[str]:
    """Say how a file is named whose name begins like an option."""
    there = [one for one in arguments if one.startswith("-") and os.path.lexists(one)]
    return [f"Write ./{there[0]} for what is called so here."] if there and "option" in error.message else []


def _of_output(status: int) -> int:
    """Return the exit status, 1 where a verb did its work and its result is not all in the file it was sent to."""
    error = lost(sys.stdout)
    if status or error is None or error.errno in BROKEN:  # whoever has closed a pipe has read enough
        return status
    click.echo(f"the result could not be printed ({error.strerror}); files are as the verb says", err=True)
    return 1
