"""``flexura demo``: the whole chain on the campaign that comes with the project."""

import time
from pathlib import Path

import click
from rich.console import Console
from rich.table import Table

from app.commands.bad_input import bad_input

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "pp-plate"


@click.command(name="demo")
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("flexura-demo"),
    show_default=True,
    help="Folder for the campaign, the results and the report.",
)
@click.pass_context
@bad_input
def command(context: click.Context, out: Path) -> None:
    """Run every stage on the shipped recording of a polypropylene plate, 0 to 60 °C; a minute or so.

    The same commands, typed one by one, do the same: each is shown before it runs.
    """
    from app.commands import compensate, focus, identify, import_campaign, report, update

    campaign, run = out / "campaign", out / "run"
    stages: list[tuple[str, click.Command, dict[str, object]]] = [
        (f"import {EXAMPLE} --out {campaign}", import_campaign.command, {"folder": EXAMPLE, "out": campaign}),
        (f"identify {campaign} --out {run}", identify.command, {"campaign": campaign, "out": run}),
        (f"update {campaign} --out {run}", update.command, {"campaign": campaign, "out": run}),
        (f"focus {run}", focus.command, {"run": run}),
        (f"compensate {run}", compensate.command, {"run": run}),
        (f"report {run}", report.command, {"run": run}),
    ]
    timings = Table(title="Demo", header_style="bold")
    timings.add_column("command")
    timings.add_column("seconds", justify="right")
    for words, verb, options in stages:
        click.secho(f"\n$ flexura {words}", bold=True, err=True)
        started = time.perf_counter()
        context.invoke(verb, **options)
        timings.add_row(f"flexura {words.split()[0]}", f"{time.perf_counter() - started:.1f}")
    Console().print(timings)
    click.echo(f"report: {(run / 'report.html').resolve()}")
