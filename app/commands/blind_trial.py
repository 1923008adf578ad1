"""``flexura blind-trial``: accuracy of the gap workflow on simulated campaigns with hidden effects."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from app.commands.bad_input import bad_input
from app.commands.options import engine_options, out_folder
from app.commands.output import Output, output_options

if TYPE_CHECKING:
    from rich.table import Table

    from app.blind_trial.assignments import Kind
    from app.blind_trial.trial import Trial
    from app.terminal.engine import Engine

KINDS: "tuple[Kind, ...]" = ("null", "single", "pair", "outside", "ablated")

CAMPAIGN_MEMORY = 1.6e9
"""Bytes that a worker takes at most, while it reduces a plate with effects."""
CAMPAIGN_AND_RUN = 3e6
"""Bytes of a campaign and its verdict, roughly: of a small plate they are 1.6 MB."""

EXAMPLES = """\b
Examples:
  flexura blind-trial --count 200 --seed 7
  flexura blind-trial --count 20 --seed 7 --kind null --kind single --exact
  flexura blind-trial --count 200 --seed 7 --cluster tcp://192.168.1.10:8786 --out /shared/trial
"""


@click.command(name="blind-trial", epilog=EXAMPLES, short_help="Measure how often the gap workflow is right.")
@click.option("--count", type=click.IntRange(1, 9999), required=True, help="How many campaigns.")
@click.option("--seed", type=click.IntRange(0), required=True, help="Everything drawn follows from it.")
@click.option(
    "--kind", "kinds", type=click.Choice(KINDS), multiple=True, help="What is hidden; may be given several times."
)
@engine_options
@click.option("--exact", is_flag=True, help="Plates exactly as declared, without small causes that nobody tells.")
@click.option("--calibrate", is_flag=True, help="Draw from the calibration's own seeds, and fit the confidence.")
@out_folder("Folder for campaigns, truth and proof (default: blind-trial-SEED).")
@output_options("what proof.json holds")
@bad_input
def command(
    count: int,
    seed: int,
    kinds: "tuple[Kind, ...]",
    engine: "Engine",
    exact: bool,
    calibrate: bool,
    out: Path | None,
    output: Output,
) -> None:
    """Make campaigns with hidden effects, judge them blind, and set the verdicts beside the truth.

    Each campaign is recorded on the simulated rig from a plate on another mesh than the twin's, with its own
    material laws, gain, noise and protocol. Every 25 campaigns add a plate: rectangles and quadrilaterals, driven
    by a patch, by an exciter, or by two patches in turn. What is hidden goes into OUT/truth, never into
    OUT/campaigns; the comparison is given the campaign's folder alone. No plate is exactly as declared: its
    dimensions and places are off as in a careful workshop, and in three of four campaigns small causes that the
    library then lacks make its resonances scatter by 0.1 to 1 %; --exact leaves both out. null: nothing is
    hidden; single, pair: effects of the library; outside: physics that it has not; ablated: an effect that it
    lacks today. Run again, it goes on where it was stopped. With --cluster the workers of a Dask cluster do it
    (docs/guide/cluster.md). Writes proof.json and proof.png. Exit status 1 where
    a figure misses its target.
    """
    from app.files.disk_room import RESULTS, require_room
    from app.files.results.run_folder import writable_folder

    stream = "calibration" if calibrate else "trial"
    folder = writable_folder(out or Path(f"blind-{stream}-{seed}"), "--out")

    from app.blind_trial.outcome import is_judged
    from app.blind_trial.trial import Trial, begin, run_trial

    wanted = tuple(kind for kind in KINDS if kind in kinds) or KINDS
    trial = Trial(folder.resolve(), count, seed, wanted, stream, exact)
    left = sum(not is_judged(trial.run(one)) for one in trial.assignments)
    require_room(folder, left * CAMPAIGN_AND_RUN + RESULTS, "--out")
    begin(trial)
    with output.progress() as report, engine.executor(folder, CAMPAIGN_MEMORY, report, output.note) as executor:
        run_trial(trial, executor, report, output.summary)
    record = _proven(trial)
    output.result(lambda: record, lambda: _show(record))
    missed = [row["name"] for row in record["figures"] if row["met"] is False]
    likeliest = record["likeliest_confidence"]
    if calibrate and likeliest:
        settings = ", ".join(f"{name} {value:.2g}" for name, value in likeliest.items())
        output.summary(f"likeliest confidence: {settings} (TEMPERATURE_OF_CONFIDENCE and UNLISTED)")
    output.summary(f"{count} campaigns, {len(missed)} figures miss their targets; results in {folder}")
    if missed:
        raise click.exceptions.Exit(1)


def _proven(trial: "Trial") -> dict[str, Any]:
    """Score a trial, and write proof.json and proof.png."""
    from app.blind_trial.outcome import read_outcome
    from app.blind_trial.proof import claims, figures, likeliest_confidence
    from app.blind_trial.proof_figure import proof_figure
    from app.files.atomic import atomic_path, write_json
    from app.report.style import drawing

    read = [read_outcome(trial.truth(a), trial.run(a)) for a in trial.assignments]
    outcomes = [o for o in read if o is not None]
    record = {
        "trial": trial.record(),
        "figures": [figure.record() for figure in figures(outcomes)],
        "likeliest_confidence": likeliest_confidence(claims(outcomes)),
        "campaigns": [o.record() for o in outcomes],
    }
    write_json(trial.folder / "proof.json", record)
    with drawing(), atomic_path(trial.folder / "proof.png") as file:
        proof_figure(outcomes).savefig(file, format="png", dpi=110)
    return record


def _show(record: dict[str, Any]) -> None:
    from rich.console import Console

    console = Console()
    console.print(figures_table(record["figures"]))
    console.print(confusion_table(record["campaigns"]))


def figures_table(rows: list[dict[str, Any]]) -> "Table":
    """Table of every figure with its target."""
    from rich.table import Table

    table = Table(title="Figures of the trial", header_style="bold")
    for heading in ("figure", "value", "95 % interval", "of", "target", ""):
        table.add_column(heading, justify="left" if heading in ("figure", "") else "right")
    for row in rows:
        value = "" if row["value"] is None else f"{row['value']:.3f}"
        interval = "" if row["low"] is None else f"{row['low']:.2f} to {row['high']:.2f}"
        table.add_row(row["name"], value, interval, str(row["count"]), _target(*row["target"]), _standing(row))
    return table


def _standing(row: dict[str, Any]) -> str:
    """Word for a figure: one that misses may do so by chance if its interval reaches the target."""
    if row["met"] is None:
        return "not measured"
    if row["met"]:
        return "met"
    low, high = row["target"]
    by_chance = row["low"] is not None and row["low"] <= high and row["high"] >= low
    return "missed, its interval reaches the target" if by_chance else "[bold red]missed[/]"


def _target(low: float, high: float) -> str:
    if low > 0.0 and high < 1.0:
        return f"{low:g} to {high:g}"
    return f"at least {low:g}" if low > 0.0 else f"at most {high:g}" if high < 1.0 else ""


def confusion_table(campaigns: list[dict[str, Any]]) -> "Table":
    """Table of the verdicts on campaigns of each kind."""
    from rich.table import Table

    answers = ("none", "explained", "partly_explained", "unknown", "refused")
    table = Table(title="Verdicts by what was hidden", header_style="bold")
    for heading in ("hidden", *answers, "right names", "right classes"):
        table.add_column(heading, justify="left" if heading == "hidden" else "right")
    for kind in KINDS:
        mine = [c for c in campaigns if c["kind"] == kind]
        if mine:
            counts = [sum(c["verdict"] == answer for c in mine) for answer in answers]
            right = [sum(c[key] for c in mine) for key in ("right_names", "right_classes")]
            table.add_row(kind, *(str(n) if n else "" for n in (*counts, *right)))
    return table
