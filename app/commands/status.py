"""``flexura status``: how campaigns stand, once, for scripts and remote shells."""

import time
from pathlib import Path

import click

from app.commands.bad_input import bad_input
from app.commands.options import PATH, require_campaigns
from app.commands.output import Output, output_options

EXAMPLES = """\b
Examples:
  flexura status my-campaign
  flexura status my-campaign --json
  ssh laboratory flexura status left-rig right-rig
"""
WORST = (3, 4, 1, 5, 0)
"""Exit statuses, the one that counts of several campaigns first."""


@click.command(name="status", epilog=EXAMPLES, short_help="How a campaign stands, in a line.")
@click.argument("campaigns", type=PATH, nargs=-1, required=True, metavar="CAMPAIGN...")
@output_options("how they stand")
@bad_input
def command(campaigns: tuple[Path, ...], output: Output) -> None:
    """Say how CAMPAIGNs stand, sweeps or hammer tests, that flexura acquire records or has recorded.

    Nothing is written. Exit status 0: complete; 1: stopped, or complete with sweeps or hits missing; 3: something
    is NOT AT REST; 4: silent, nothing was written for longer than a sweep and a margin (of a hammer test: its
    process is gone, and nothing says that its oven is at rest); 5: under way, or not begun. Of several campaigns
    the first of 3, 4, 1, 5, 0 that occurs.
    """
    require_campaigns(campaigns)
    from app.watch.watcher import WatchedFolder, names, require_acquired

    for one in campaigns:
        require_acquired(one)
    folders = [WatchedFolder(one, name) for one, name in zip(campaigns, names(campaigns), strict=True)]
    statuses = [one.look(time.time()) for one in folders]

    def show() -> None:
        for one in statuses:
            click.echo(f"{one.name}: {one.line}")

    output.result(lambda: [one.record() for one in statuses], show)
    worst = next(status for status in WORST if status in {one.exit_status for one in statuses})
    if worst:
        raise click.exceptions.Exit(worst)
