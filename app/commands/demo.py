"""``flexura demo``: a campaign on the simulated rig, the whole chain on a recorded one, a gap found and closed."""

import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from app.commands.bad_input import bad_input

if TYPE_CHECKING:
    from rich.table import Table

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
EXPERIMENT = EXAMPLES / "simulated-rig.toml"
RECORDING = EXAMPLES / "pp-plate"
PUZZLE = EXAMPLES / "hidden-effect.toml"


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


def run_stages(part: Part) -> tuple[int, dict[str, float]]:
    """Do every stage as if it were typed; the worst exit status, and the seconds each verb took."""
    from app.main import flexura

    seconds, worst = {}, 0
    for words in part.stages:
        click.secho(f"\n$ flexura {' '.join(words)}", bold=True, err=True)
        started = time.perf_counter()
        status = flexura.main(words, prog_name="flexura", standalone_mode=False)
        seconds[words[0]] = time.perf_counter() - started
        worst = max(worst, status if isinstance(status, int) else 0)
    return worst, seconds


@click.command(name="demo")
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("flexura-demo"),
    show_default=True,
    help="Folder for the campaigns, the results and the report.",
)
@bad_input
def command(out: Path) -> None:
    """Run everything on three campaigns; about two minutes, a few more the first time.

    Simulated cards (an NI gRPC device server on a loopback port) and a simulated oven measure a simulated plate
    from 0 to 60 °C; what identification and updating find is set against what was put in. Then the whole chain
    runs on the shipped recording of a polypropylene plate. Last, a simulated plate has something that its twin
    lacks: flexura gap finds what, and the report shows the gap before and after. The same commands, typed one by
    one, do the same: each is shown before it runs.
    """
    from rich.console import Console

    acquired, recorded, puzzle = parts_in(out)
    done = [(part, *run_stages(part)) for part in (acquired, recorded, puzzle)]
    console = Console()
    console.print()
    console.print(stages_table({part: seconds for part, _, seconds in done}))
    console.print(laws_table(acquired.run))
    console.print(effects_table(puzzle.run))
    for part in (recorded, puzzle):
        click.echo(f"report: {(part.run / 'report.html').resolve()}")
    worst = max(status for _, status, _ in done)
    if worst:
        raise click.exceptions.Exit(worst)


def stages_table(seconds: dict[Part, dict[str, float]]) -> "Table":
    """Say in a line what each stage of each campaign found, and how long it took."""
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


def laws_table(run: Path) -> "Table":
    """Set the laws found in the acquired campaign against those the simulated plate was made of."""
    import numpy as np
    from rich.table import Table

    from app.files.experiment_toml import read_acquired_experiment
    from app.files.laws_file import load_laws

    experiment = read_acquired_experiment(EXPERIMENT)
    if experiment.simulation is None:
        raise ValueError(f"{EXPERIMENT} simulates nothing")
    laws = load_laws(run / "laws.h5")
    temperature = np.array(experiment.protocol.recorded().temperatures)
    low, high = laws.temperature_range
    temperature = temperature[(temperature >= low) & (temperature <= high)]
    put_in, found = experiment.simulation.laws.laws().at(temperature), laws.at(temperature)
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


def effects_table(run: Path) -> "Table":
    """Set what was hidden in the last campaign's plate against what `flexura gap` named."""
    from rich.table import Table

    from app.files.experiment_toml import read_acquired_experiment
    from app.files.gap_file import load_gap
    from app.gap_words import estimate, named, verdict_words

    experiment = read_acquired_experiment(PUZZLE)
    if experiment.simulation is None:
        raise ValueError(f"{PUZZLE} simulates nothing")
    _, record = load_gap(run / "gap.h5")
    table = Table(title="The plate with something hidden: what it is, what was found", header_style="bold")
    for heading in ("", "effect", "values"):
        table.add_column(heading)
    for name, values in experiment.simulation.effects.items():
        table.add_row("put in", name, ", ".join(f"{key} {value:g}" for key, value in values.items()))
    for effect in record["effects"]:
        values = ", ".join(f"{key} {estimate(found)}" for key, found in effect["parameters"].items())
        table.add_row("found", named(effect), values)
    closure = record["gap"]["held_out"]["closure"]
    closed = "" if closure is None else f"; {100 * closure:.1f} % of the gap is closed on data held out"
    table.caption = verdict_words(record["verdict"]) + closed
    return table
