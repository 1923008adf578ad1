"""``flexura demo``: the whole chain on the campaign that comes with the project."""

import time
from pathlib import Path

import click

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
@bad_input
def command(out: Path) -> None:
    """Run every stage on the shipped recording of a polypropylene plate, 0 to 60 °C; a minute or two.

    The same commands, typed one by one, do the same: each is shown before it runs.
    """
    from rich.console import Console
    from rich.table import Table

    from app.main import flexura
    from app.report.summary import summary

    campaign, run = str(out / "campaign"), str(out / "run")
    stages = [
        ["import", str(EXAMPLE), "--out", campaign],
        ["identify", campaign, "--out", run],
        ["update", campaign, "--out", run],
        ["focus", run],
        ["compensate", run],
        ["report", run],
    ]
    seconds, worst = {}, 0
    for words in stages:
        click.secho(f"\n$ flexura {' '.join(words)}", bold=True, err=True)
        started = time.perf_counter()
        status = flexura.main(words, prog_name="flexura", standalone_mode=False)
        seconds[words[0]] = time.perf_counter() - started
        worst = max(worst, status if isinstance(status, int) else 0)
    table = Table(title="What the demo found", header_style="bold")
    for heading in ("stage", "result", "seconds"):
        table.add_column(heading, justify="right" if heading == "seconds" else "left")
    found = summary(Path(run))
    for verb, took in seconds.items():
        table.add_row(verb, found.get(verb, ""), f"{took:.1f}")
    Console().print(table)
    click.echo(f"report: {(Path(run) / 'report.html').resolve()}")
    if worst:
        raise click.exceptions.Exit(worst)
