"""``flexura gap``: where twin and data disagree, and which effect the twin lacks."""

import time
from pathlib import Path

import click

from app.commands.bad_input import bad_input
from app.commands.options import CAMPAIGN, EXPERIMENT, PATH, effects_of_twin, mains, own_effects, run_out
from app.commands.output import Output, output_options

EXAMPLES = """\b
Examples:
  flexura gap plate --out plate-run
  flexura gap plate --twin plate-run/twin.toml --out plate-again
  flexura gap plate --effects my-effects --json
  flexura gap plate --plan --experiment rig.toml --hours both_ramps=6
  flexura gap plate-again --after plate plate-run
"""


def _hours(_: click.Context, __: click.Parameter, values: tuple[str, ...]) -> dict[str, float]:
    """Split ``KIND=HOURS``; the request refuses what no kind or no duration is."""
    found = {}
    for value in values:
        kind, _sign, hours = value.partition("=")
        try:
            found[kind] = float(hours)
        except ValueError:
            raise click.BadParameter(f"{value!r}; allowed: KIND=HOURS, a number of hours") from None
    return found


@click.command(name="gap", epilog=EXAMPLES, short_help="Name the effect that the twin lacks.")
@click.argument("campaign", type=CAMPAIGN)
@click.option("--plan", is_flag=True, help="Say which measurement would settle what stays open.")
@click.option(
    "--experiment",
    type=EXPERIMENT,
    metavar="FILE",
    help="With --plan: file by which CAMPAIGN was acquired (default: what its folder holds of it).",
)
@click.option(
    "--hours",
    multiple=True,
    callback=_hours,
    metavar="KIND=HOURS",
    help="With --plan: laboratory hours of a kind of measurement.",
)
@click.option(
    "--after",
    nargs=2,
    type=PATH,
    metavar="CAMPAIGN RUN",
    help="An earlier campaign and its run folder, whose plan this one follows: both decide what was open.",
)
@effects_of_twin
@own_effects
@run_out
@mains
@output_options("what gap.json holds")
@bad_input
def command(
    campaign: Path,
    twin: Path | None,
    effects: Path | None,
    plan: bool,
    experiment: Path | None,
    hours: dict[str, float],
    after: tuple[Path, Path] | None,
    out: Path | None,
    mains: float,
    output: Output,
) -> None:
    """Compare CAMPAIGN with its twin and name what the twin lacks.

    Fits the twin of the declared plate with nothing but its material laws and one gain, finds where the residual
    exceeds the noise, and tries every effect of the library on it. An effect is accepted by its remaining residual
    and by data that it was not fitted to; where none is good enough, the verdict is unknown. Writes gap.json,
    gap.h5 (for flexura report), twin.toml (the twin with what was found) and laws-corrected.h5 (its laws) into the
    run folder. Where the modes of twin and plate do not pair, this is no fit: no effect is named, the verdict is
    unknown, and the likely reason is looked for. The result is printed in words, too, and all other verbs use the
    corrected laws from then on. Exit status 0: no gap, or explained; 1: partly explained or unknown; 2: input that
    cannot be judged.

    With --plan, measurements that could be made next (another ramp, level, band, sensor, a known mass, a scale, a
    micrometer, ...) are simulated on the twin as found, and ranked by how far they set apart, per hour, what this
    campaign cannot: effects that look alike, and those it cannot show. The best campaign is written as
    next-experiment.toml, for flexura acquire.

    With --after, what an earlier comparison left open is decided by both campaigns together.

    CAMPAIGN may be running or interrupted: its finished sweeps are taken, and the result says how many of how many
    they are. Do the same again when more are there: laws.h5 of fewer sweeps is then made again, too.
    """
    from app.files.campaigns.loading import load_campaign
    from app.files.campaigns.of_run import campaign_typed, remember_campaign
    from app.files.disk_room import room_of
    from app.files.results.best_twin import best_twin
    from app.files.results.run_folder import run_folder
    from app.summaries.briefing import briefing
    from app.summaries.gap import summary, tables
    from app.summaries.numbers import led
    from app.terminal.tables import show

    loaded = load_campaign(campaign)
    earlier = None if after is None else (load_campaign(after[0]), after[1])
    rig = None
    if plan or experiment:
        from app.files.results.next_experiment import rig_table

        rig = rig_table(campaign, experiment)
    from app.stages import gap  # the import takes a second: a wrong folder is reported before it
    from app.stages.gap import GapRequest

    request = GapRequest(
        loaded, twin=twin, effects=effects, mains=mains, plan=plan, hours=hours, rig=rig, after=earlier
    )
    started = time.perf_counter()
    with run_folder(campaign, out, room_of(campaign)) as run, output.progress() as report:
        found = gap.compute(request, report, run=run)
        record = gap.save(run, request, found, time.perf_counter() - started)
        remember_campaign(run, campaign)
    words = briefing(best_twin(run, "gap"), record, campaign_typed(campaign, out)).lines()
    output.result(lambda: record, lambda: show(tables(record), words))
    planned = record["plan"]["notes"] if plan else ()
    for note in (*found.frf.notes, *record["notes"], *planned):
        output.note(note)
    output.summary(f"{led(loaded.extent)}{summary(record, run)}")
    if found.report.verdict not in gap.GOOD:
        raise click.exceptions.Exit(1)
