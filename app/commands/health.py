"""``flexura health``: what has changed on a panel since its baseline."""

from pathlib import Path

import click

from app.commands.bad_input import bad_input
from app.commands.options import RUN, RUN_WITH_LAWS, mains, out_folder, picture
from app.commands.output import Output, output_options

EXAMPLES = """\b
Examples:
  flexura health week-01 week-02 week-03 --baseline panel-run
  flexura health weeks/* --baseline panel-run --picture --out panel-health
  flexura health weeks/* --baseline panel-run --rate 0.0001 --json
  flexura health sweep-of-march music-of-april --baseline panel-run
"""


@click.command(name="health", epilog=EXAMPLES, short_help="Say what has changed on a panel since its baseline.")
@click.argument("dates", type=RUN, nargs=-1, required=True, metavar="RUN...")
@click.option(
    "--baseline",
    type=RUN_WITH_LAWS,
    required=True,
    metavar="RUN0",
    help="Run folder (of flexura update) of the panel when it was healthy.",
)
@click.option(
    "--rate",
    type=click.FloatRange(1e-9, 0.1),
    default=1e-3,
    show_default=True,
    help="False alarms per date, at most.",
)
@picture
@out_folder("Folder for health.json (default: RUN0).")
@mains
@output_options("what health.json holds")
@bad_input
def command(
    dates: tuple[Path, ...],
    baseline: Path,
    rate: float,
    mains: float,
    picture: bool,
    out: Path | None,
    output: Output,
) -> None:
    """Judge a panel on each date by the responses between its patches, and name what has changed.

    RUN... are the dates in order of time: run folders with frf.h5 (of flexura identify or update), campaign
    folders, or folders with drive.wav and response.wav: sound that the panel played and what it answered, a
    channel for each actuator and sensor. One temperature is enough on a date; every actuator of the baseline must
    have driven. Temperatures need not be known: the panel is its own thermometer.

    RUN0 is the run folder of a campaign of the same panel at four temperatures or more, over the whole range
    that later dates may have. Its twin, and what its recordings show beside the twin, predict the healthy panel
    at any temperature of that range. An alarm is given where a softer bond, lost polarization, local damage, an
    added mass or a changed support explains the difference by more than noise and errors of the baseline do, or
    where there is a difference that none of them explains. Writes health.json. Exit status 0: no change on the
    last date; 1: changed, or no date could be judged.
    """
    from app.files.campaigns.kind import declared_date
    from app.files.results.best_twin import best_twin
    from app.files.results.run_folder import run_file, run_folder

    best_twin(baseline, "health")
    run_file(baseline, "frf.h5", "health")
    for one in dates:
        declared_date(one)
    from app.stages import health  # the import takes a second: a wrong folder is reported before it
    from app.summaries.health import headline, tables
    from app.terminal.tables import show

    with run_folder(baseline, out or baseline) as folder, output.progress() as report:
        request = health.HealthRequest(baseline=baseline, dates=dates, rate=rate, mains=mains)
        found = health.compute(request, report)
        record = health.save(folder, found)
    target = folder / health.HEALTH
    if picture:
        from app.report.health import trend
        from app.report.style import saved

        saved(target.with_suffix(".png"), lambda: trend(found.report))
    output.result(lambda: record, lambda: show(tables(found.report)))
    for note in found.notes:
        output.note(note)
    if not found.report.judged:
        output.failure(f"{headline(found.report)}; {target}")
        raise click.exceptions.Exit(1)
    output.summary(f"{headline(found.report)}; {target}")
    if found.report.found is not None:
        raise click.exceptions.Exit(1)
