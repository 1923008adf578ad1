"""``flexura gap``: where twin and data disagree, and which effect the twin lacks."""

import json
import time
from pathlib import Path
from typing import TYPE_CHECKING

import click

from app.commands.bad_input import bad_input
from app.progress import progress

if TYPE_CHECKING:
    pass

GOOD = ("none", "explained")


@click.command(name="gap")
@click.argument("campaign", type=click.Path(path_type=Path))
@click.option("--twin", type=click.Path(path_type=Path), help="Twin file to start from; its effects stay on.")
@click.option("--effects", type=click.Path(path_type=Path), help="Folder with effects of your own (*.py).")
@click.option("--out", type=click.Path(path_type=Path), help="Run folder (default: NAME-run beside CAMPAIGN).")
@click.option(
    "--mains", type=float, default=50.0, show_default=True, help="Mains frequency, Hz, for lines left out."
)
@click.option("--json", "as_json", is_flag=True, help="Print gap.json.")
@bad_input
def command(
    campaign: Path, twin: Path | None, effects: Path | None, out: Path | None, mains: float, as_json: bool
) -> None:
    """Compare CAMPAIGN with its twin and name what the twin lacks.

    Fits the twin of the declared plate with nothing but its material laws and one gain, looks where more than
    noise is left, and tries every effect of the library on it. A name is accepted on what it leaves and on data it
    was not fitted to; where none is good enough, the verdict is unknown. Writes gap.json, gap.h5 (for flexura
    report), twin.toml (the twin with what was found) and laws-corrected.h5 (its laws) into the run folder. Files
    in --effects FOLDER are run as Python: use your own only. Exit status 0: no gap, or explained; 1: partly
    explained or unknown; 2: input that cannot be judged.
    """
    from app.campaign_model import start_of
    from app.files.campaign import load_campaign
    from app.files.provenance import sha256
    from app.files.run_folder import run_folder
    from app.gap import campaign_gap
    from app.gap_result import made_from, save_comparison
    from app.gap_words import show, summary

    loaded = load_campaign(campaign)
    start = start_of(twin, loaded.experiment, effects)
    run = run_folder(campaign, out)
    started = time.perf_counter()
    with progress() as report:
        found = campaign_gap(loaded, mains, report, start=start, folder=effects)
    origin = made_from(loaded, mains, twin, effects)
    based_on = sha256(twin) if twin is not None else None
    record = save_comparison(run, loaded, found, origin, based_on, time.perf_counter() - started)
    if as_json:
        click.echo(json.dumps(record, indent=1, allow_nan=False))
    else:
        show(record)
    for note in (*found.frf.notes, *record["notes"]):
        click.echo(f"note: {note}", err=True)
    click.echo(summary(record, run), err=True)
    if found.report.verdict not in GOOD:
        raise click.exceptions.Exit(1)
