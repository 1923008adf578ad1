"""``flexura status``: how campaigns stand, once, for scripts and remote shells."""

import os
import time
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import click

from app.commands.bad_input import bad_input
from app.commands.options import PATH, require_campaigns
from app.commands.output import Output, output_options
from app.files.bad_file import ResultFileError
from app.files.campaign_error import CampaignFileError

EXAMPLES = """\b
Examples:
  flexura status my-campaign
  flexura status my-campaign --json
  ssh laboratory flexura status left-rig right-rig
"""
BAD_NAME = 2
WORST = (3, 4, BAD_NAME, 1, 5, 0)
"""Exit statuses, the one that counts of several campaigns first."""


def _refused(check: Callable[[tuple[Path, ...]], None], folder: Path) -> str:
    """Why a folder is no campaign that can be told; empty where it is one."""
    try:
        check((folder,))
    except click.ClickException as error:
        return error.message
    except (CampaignFileError, ResultFileError) as error:
        return str(error)
    except OSError as error:
        return f"{folder}: cannot be read: {error.strerror}"
    return ""


def _each_once(named: Iterable[Path]) -> list[Path]:
    """Return folders without those named twice, and without their locks, which ``*`` of a shell takes, too."""
    locks = {one for one in named if one.suffix == ".lock" and one.is_file() and one.with_suffix("").is_dir()}
    return list({os.path.realpath(one): one for one in named if one not in locks}.values())


def _records(refused: Mapping[Path, str]) -> list[dict[str, Any]]:
    """Return what ``--json`` prints of folders that are no campaigns."""
    return [
        {"name": one.name, "folder": str(one), "state": "refused", "problem": why, "exit_status": BAD_NAME}
        for one, why in refused.items()
    ]


@click.command(name="status", epilog=EXAMPLES, short_help="How a campaign stands, in a line.")
@click.argument("campaigns", type=PATH, nargs=-1, required=True, metavar="CAMPAIGN...")
@output_options("how they stand")
@bad_input
def command(campaigns: tuple[Path, ...], output: Output) -> None:
    """Say how CAMPAIGNs stand, sweeps or hammer tests, that flexura acquire records or has recorded.

    Nothing is written. Exit status 0: complete; 1: stopped, or complete with sweeps or hits missing; 3: something
    is NOT AT REST; 4: silent, its process is gone, or nothing was written for longer than a sweep and a margin
    (of a hammer test: its process is gone, and nothing says that its oven is at rest); 5: under way, or not begun.
    Of several campaigns the first of 3, 4, 2, 1, 5, 0 that occurs; 2: a name is no campaign, and the others are
    told nevertheless.
    """
    named = _each_once(campaigns)
    refused = {one: why for one in named if (why := _refused(require_campaigns, one))}
    told = [one for one in named if one not in refused]
    if told:
        from app.watch.watcher import WatchedFolder, names, require_acquired

        refused |= {one: why for one in told if (why := _refused(lambda named: require_acquired(*named), one))}
        told = [one for one in named if one not in refused]
    if not told:
        raise click.ClickException("\n".join(refused.values()))
    folders = [WatchedFolder(one, name) for one, name in zip(told, names(told), strict=True)]
    statuses = [one.look(time.time()) for one in folders]

    def show() -> None:
        for one in statuses:
            click.echo(f"{one.name}: {one.line}")

    output.result(lambda: [*(one.record() for one in statuses), *_records(refused)], show)
    for why in refused.values():
        output.failure(f"Error: {why}")
    ended = {one.exit_status for one in statuses} | ({BAD_NAME} if refused else set())
    worst = next(status for status in WORST if status in ended)
    if worst:
        raise click.exceptions.Exit(worst)
