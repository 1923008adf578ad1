"""``flexura demo``: a campaign on the simulated rig, the whole chain on a recorded one, a gap found and closed."""

import sys
import time
from contextlib import redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from app.commands import demo_truth
from app.commands.bad_input import bad_input
from app.commands.options import out_folder
from app.commands.output import Output, output_options
from app.files.shipped import shipped

if TYPE_CHECKING:
    from rich.table import Table

RECORDING = shipped("pp-plate")
QUICK, QUICK_PANEL = shipped("quick-rig.toml"), shipped("quick-panel.toml")
"""The plate of `demo_truth.EXPERIMENT` in a narrow band at four temperatures, and a panel that is fast to
reduce."""
EXAMPLES = """\b
Examples:
  flexura demo
  flexura demo --quick
  flexura demo --out demo-run --quiet
"""


@dataclass(frozen=True)
class Part:
    """One campaign, its run folder, and the stages it goes through."""

    name: str
    run: Path
    stages: tuple[tuple[str, ...], ...]


def parts_in(out: Path) -> tuple[Part, Part, Part]:
    """Return the acquired campaign, the recorded one, and one of a plate with something hidden, files in `out`."""
    acquired, acquired_run = str(out / "simulated"), str(out / "simulated-run")
    campaign, run = str(out / "campaign"), str(out / "run")
    puzzle, puzzle_run = str(out / "puzzle"), str(out / "puzzle-run")
    acquired_stages = (
        ("acquire", str(demo_truth.EXPERIMENT), "--out", acquired),
        ("identify", acquired, "--out", acquired_run),
        ("update", acquired, "--out", acquired_run),
    )
    recorded_stages = (
        ("import", str(RECORDING), "--out", campaign),
        ("identify", campaign, "--out", run),
        ("update", campaign, "--out", run),
        ("focus", run),
        ("compensate", run),
        ("report", run),
    )
    puzzle_stages = (
        ("acquire", str(demo_truth.PUZZLE), "--out", puzzle),
        ("gap", puzzle, "--out", puzzle_run),
        ("report", puzzle_run),
    )
    return (
        Part("acquired", Path(acquired_run), acquired_stages),
        Part("recorded", Path(run), recorded_stages),
        Part("puzzle", Path(puzzle_run), puzzle_stages),
    )


def quick_part(out: Path) -> Part:
    """Return one short acquired campaign, from the rig to filters and a report, files in `out`."""
    campaign, run = str(out / "quick"), str(out / "quick-run")
    stages = (
        ("acquire", str(QUICK), "--out", campaign),
        ("identify", campaign, "--out", run),
        ("update", campaign, "--out", run),
        ("focus", run, "--panel", str(QUICK_PANEL)),
        ("report", run),
    )
    return Part("quick", Path(run), stages)


def run_stages(part: Part, *, quiet: bool = False) -> tuple[int, dict[str, float]]:
    """Run every stage as if typed; return the worst exit status, and the seconds each verb took."""
    from app.main import flexura

    seconds, worst = {}, 0
    for words in part.stages:
        if not quiet:
            click.secho(f"\n$ flexura {' '.join(words)}", bold=True, err=True)
        started = time.perf_counter()
        asked = (*words, "--quiet") if quiet else words
        status = flexura.main(asked, prog_name="flexura", standalone_mode=False)
        seconds[words[0]] = time.perf_counter() - started
        worst = max(worst, status if isinstance(status, int) else 0)
    return worst, seconds


@click.command(name="demo", epilog=EXAMPLES, short_help="Run every stage on examples, in a few minutes.")
@click.option(
    "--quick", is_flag=True, help="One short campaign only, without a gap: a minute or two, also at first."
)
@out_folder("Folder for the campaigns, the results and the report (default: flexura-demo).")
@output_options("what was found")
@bad_input
def command(quick: bool, out: Path | None, output: Output) -> None:
    """Run everything on three campaigns; five minutes the first time, about one after that.

    Simulated cards (an NI gRPC device server on a loopback port) and a simulated oven measure a simulated plate
    from 0 to 60 °C; results of identification and updating are compared with the values put in. Then the whole
    chain runs on the shipped recording of a polypropylene plate. Last, a simulated plate has something that its
    twin lacks: flexura gap finds what, and the report shows the gap before and after. The same commands, typed one
    by one, do the same: each is shown before it runs. With --quick, one campaign of four temperatures up to 600 Hz
    goes from the rig to filters of a small panel and a report.
    """
    from app.files.run_folder import writable_folder

    folder = writable_folder(out or Path("flexura-demo"), "--out")
    parts = (quick_part(folder),) if quick else parts_in(folder)
    with redirect_stdout(sys.stderr):  # stdout is for the result of the demo
        done = [(part, *run_stages(part, quiet=output.quiet)) for part in parts]
    seconds = {part: took for part, _, took in done}
    pages = [(part.run / "report.html").resolve() for part in parts if "report" in seconds[part]]
    acquired, puzzle = parts[0].run, None if quick else parts[-1].run
    output.result(lambda: record(seconds, acquired, puzzle, pages), lambda: show(seconds, acquired, puzzle, pages))
    total = sum(sum(took.values()) for took in seconds.values())
    count = "one campaign" if quick else f"{len(parts)} campaigns"
    output.summary(f"{count} in {total:.1f} s, {'report' if quick else 'two reports'} in {pages[0].parents[1]}")
    worst = max(status for _, status, _ in done)
    if worst:
        raise click.exceptions.Exit(worst)


def record(
    seconds: dict[Part, dict[str, float]], run: Path, puzzle: Path | None, pages: list[Path]
) -> dict[str, Any]:
    """Return what ``--json`` prints: seconds per stage, laws and effects put in and found, reports.

    Parameters
    ----------
    seconds : dict of Part to dict of str to float
        Time that each stage of each part took, s.
    run : Path
        Run folder of the campaign without effects.
    puzzle : Path or None
        Run folder of the campaign with hidden effects; None where there is none.
    pages : list of Path
        Reports.

    Returns
    -------
    dict
        Of JSON values.
    """
    temperature, put_in, found = demo_truth.laws_beside(run)
    values: dict[str, Any] = {
        "seconds": {part.name: took for part, took in seconds.items()},
        "temperatures_c": temperature.tolist(),
        "laws": {
            name: {"put_in": getattr(put_in, name).tolist(), "found": getattr(found, name).tolist()}
            for name in ("youngs_modulus", "poisson_ratio", "loss_factor")
        },
    }
    if puzzle is not None:
        hidden, gap = demo_truth.effects_beside(puzzle)
        values["effects"] = {"put_in": hidden, "verdict": gap["verdict"], "found": gap["effects"]}
    return values | {"reports": [str(page) for page in pages]}


def show(seconds: dict[Part, dict[str, float]], run: Path, puzzle: Path | None, pages: list[Path]) -> None:
    """Print the tables and the paths of the reports.

    Parameters
    ----------
    seconds : dict of Part to dict of str to float
        Time that each stage of each part took, s.
    run : Path
        Run folder of the campaign without effects.
    puzzle : Path or None
        Run folder of the campaign with hidden effects; None where there is none.
    pages : list of Path
        Reports.
    """
    from rich.console import Console

    console = Console()
    console.print(stages_table(seconds))
    console.print(demo_truth.laws_table(run))
    if puzzle is not None:
        console.print(demo_truth.effects_table(puzzle))
    for page in pages:
        click.echo(f"report: {page}")


def stages_table(seconds: dict[Part, dict[str, float]]) -> "Table":
    """Table with the result and the time of each stage of each campaign."""
    from rich.table import Table

    from app.report.summary import summary

    table = Table(title="What the demo found", header_style="bold")
    for heading in ("campaign", "stage", "result", "seconds"):
        table.add_column(heading, justify="right" if heading == "seconds" else "left")
    for part, took in seconds.items():
        found = summary(part.run)
        found["acquire"] = found.get("import", "")
        page = part.run / "report.html"
        if page.is_file():
            found["report"] = f"one page, {page.stat().st_size / 1e6:.1f} MB, that fetches nothing"
        for number, verb in enumerate(took):
            table.add_row("" if number else part.name, verb, found.get(verb, ""), f"{took[verb]:.1f}")
        table.add_section()
    return table
