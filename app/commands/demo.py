"""``flexura demo``: a campaign on the simulated rig, the whole chain on a recorded one, a gap found and closed."""

import sys
import time
from contextlib import redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from app.commands.bad_input import bad_input
from app.commands.options import out_folder
from app.commands.output import Output, output_options
from app.files.shipped import shipped

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy as np
    from rich.table import Table

    from analysis.experiment import Experiment
    from analysis.material import Material
    from app.summaries.gap import Record


RECORDING = shipped("pp-plate")
EXPERIMENT, PUZZLE = shipped("simulated-rig.toml"), shipped("hidden-effect.toml")
QUICK, QUICK_PANEL = shipped("quick-rig.toml"), shipped("quick-panel.toml")
"""The plate of `EXPERIMENT` in a narrow band at four temperatures, and a panel that is fast to reduce."""
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


def laws_beside(run: Path) -> "tuple[np.ndarray[Any, np.dtype[np.float64]], Material, Material]":
    """Temperatures of the acquired campaign, °C, and the laws there: put into the plate, and found."""
    import numpy as np

    from app.files.declarations.experiment import read_acquired_experiment
    from app.files.results.best_twin import best_twin

    experiment = read_acquired_experiment(EXPERIMENT)
    if experiment.simulation is None:
        raise ValueError(f"{EXPERIMENT} simulates nothing")
    laws = best_twin(run, "report").twin.laws
    if laws is None:
        raise ValueError(f"{run}: too few temperatures for laws")
    temperature = np.array(experiment.protocol.recorded().temperatures)
    low, high = laws.temperature_range
    temperature = temperature[(temperature >= low) & (temperature <= high)]
    return temperature, experiment.simulation.laws.laws().at(temperature), laws.at(temperature)


def laws_table(run: Path) -> "Table":
    """Table of the laws found in the acquired campaign and those of the simulated plate."""
    import numpy as np
    from rich.table import Table

    temperature, put_in, found = laws_beside(run)
    table = Table(title="The simulated plate: laws put in, laws found", header_style="bold")
    for heading in ("T [°C]", "E put in [GPa]", "found", "ν put in", "found", "η put in [%]", "found"):
        table.add_column(heading, justify="right")
    columns = (
        (put_in.youngs_modulus, found.youngs_modulus, 1e9, ".4f"),
        (put_in.poisson_ratio, found.poisson_ratio, 1.0, ".4f"),
        (put_in.loss_factor, found.loss_factor, 0.01, ".3f"),
    )
    for t, degrees in enumerate(temperature):
        row = [f"{value[t] / unit:{form}}" for *pair, unit, form in columns for value in pair]
        table.add_row(f"{degrees:.0f}", *row)
    off = {
        "E": f"{100 * np.abs(found.youngs_modulus / put_in.youngs_modulus - 1.0).max():.3f} %",
        "ν": f"{np.abs(found.poisson_ratio - put_in.poisson_ratio).max():.5f}",
        "η": f"{100 * np.abs(found.loss_factor / put_in.loss_factor - 1.0).max():.3f} %",
    }
    table.caption = "largest difference: " + ", ".join(f"{name} {value}" for name, value in off.items())
    return table


def effects_beside(run: Path) -> "tuple[dict[str, dict[str, float]], Record]":
    """Effects hidden in the last campaign's plate, and the result of `flexura gap`."""
    from app.files.results.gap_file import load_gap

    return puzzle_experiment()[1], load_gap(run / "gap.h5")[1]


def puzzle_experiment() -> "tuple[Experiment, dict[str, dict[str, float]]]":
    """Read the declaration of the last campaign, and the effects hidden in its plate."""
    from app.files.declarations.experiment import read_acquired_experiment

    experiment = read_acquired_experiment(PUZZLE)
    if experiment.simulation is None:
        raise ValueError(f"{PUZZLE} simulates nothing")
    return experiment.recorded(experiment.sample_rate), experiment.simulation.effects


def put_in() -> "Iterator[tuple[str, str]]":
    """Yield the effects hidden in the last campaign's plate, with values and units."""
    from app.summaries.numbers import with_sigma
    from simulation.effects.library import LIBRARY

    experiment, effects = puzzle_experiment()
    for name, values in effects.items():
        card = LIBRARY[name].card(experiment)
        units = {parameter.name: parameter.unit for parameter in card.parameters}
        yield name, ", ".join(f"{key} {with_sigma(value, 0.0, units[key])}" for key, value in values.items())


def effects_table(run: Path) -> "Table":
    """Table of the effects hidden in the last campaign's plate and those named by `flexura gap`."""
    from rich.table import Table

    from app.files.results.gap_file import load_gap
    from app.summaries.gap import estimate, gap_closed, named, verdict_words

    gap = load_gap(run / "gap.h5")[1]
    table = Table(title="The plate with something hidden: what it is, what was found", header_style="bold")
    for heading in ("", "effect", "values"):
        table.add_column(heading)
    for name, values in put_in():
        table.add_row("put in", name, values)
    for effect in gap["effects"]:
        values = ", ".join(f"{key} {estimate(found)}" for key, found in effect["parameters"].items())
        table.add_row("found", named(effect), values)
    closed = gap_closed(gap["gap"]["held_out"])
    table.caption = verdict_words(gap["verdict"]) + (
        f"; {closed} of the gap closes on held-out data" if closed else ""
    )
    return table


def parts_in(out: Path) -> tuple[Part, Part, Part]:
    """Return the acquired campaign, the recorded one, and one of a plate with something hidden, files in `out`."""
    acquired, acquired_run = str(out / "simulated"), str(out / "simulated-run")
    campaign, run = str(out / "campaign"), str(out / "run")
    puzzle, puzzle_run = str(out / "puzzle"), str(out / "puzzle-run")
    acquired_stages = (
        ("acquire", str(EXPERIMENT), "--out", acquired),
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
        ("acquire", str(PUZZLE), "--out", puzzle),
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
    from app.files.results.run_folder import writable_folder

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
    temperature, put_in, found = laws_beside(run)
    values: dict[str, Any] = {
        "seconds": {part.name: took for part, took in seconds.items()},
        "temperatures_c": temperature.tolist(),
        "laws": {
            name: {"put_in": getattr(put_in, name).tolist(), "found": getattr(found, name).tolist()}
            for name in ("youngs_modulus", "poisson_ratio", "loss_factor")
        },
    }
    if puzzle is not None:
        hidden, gap = effects_beside(puzzle)
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
    console.print(laws_table(run))
    if puzzle is not None:
        console.print(effects_table(puzzle))
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
