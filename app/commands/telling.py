"""Options that say how people are told what becomes of a campaign."""

from collections.abc import Callable
from typing import TypeVar

import click

Verb = TypeVar("Verb", bound=Callable[..., object])

_NOTIFY = click.option(
    "--notify",
    multiple=True,
    metavar="ADDRESS",
    help="Tell an address of Apprise (mail, Teams, Slack, ntfy, MQTT, ...). $NAME in it: a variable of the "
    "environment; @FILE: addresses from a file of mode 600. Needs the extra notify.",
)
_COMMAND = click.option(
    "--notify-command",
    multiple=True,
    metavar="COMMAND",
    help="Tell a command: program and arguments, no shell; the message is on its standard input.",
)


def telling_options(verb: Verb) -> Verb:
    """Add --notify and --notify-command to a verb."""
    return _NOTIFY(_COMMAND(verb))
