"""Campaigns that are watched, and options that say how people are told what becomes of them."""

from collections.abc import Callable, Sequence
from pathlib import Path
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


def require_campaigns(folders: Sequence[Path], *, wait: bool = False) -> None:
    """Refuse folders that hold no campaign, before slow imports; with `wait`, they need not be there yet."""
    from app.files.campaign_kind import HAMMER_TEST, PROTOCOL, is_campaign_folder, is_hammer_folder

    for folder in folders:
        there = folder.exists()
        if not (is_campaign_folder(folder) or is_hammer_folder(folder)) and (there or not wait):
            held = "is no campaign of flexura acquire" if there else "does not exist"
            allowed = f"allowed: a folder with {PROTOCOL} or {HAMMER_TEST}, as flexura acquire makes it"
            raise click.ClickException(f"{folder}: {held}; {allowed}")


def telling_options(verb: Verb) -> Verb:
    """Add --notify and --notify-command to a verb."""
    return _NOTIFY(_COMMAND(verb))
