"""``flexura run``: everything from files to the report, in one process."""

import time
from pathlib import Path
from typing import TYPE_CHECKING

import click

from app.commands.bad_input import bad_input
from app.commands.options import CAMPAIGN, Existing, run_out
from app.commands.output import Output, output_options

if TYPE_CHECKING:
    from app.files.run_record import StageRecord
    from app.files.run_settings import Stage

STAGES = click.Choice(["import", "identify", "update", "gap", "focus", "compensate", "report"])
SETTINGS = Existing("allowed: a TOML file with a table [run]")
EXAMPLES = """\b
Examples:
  flexura run examples/pp-plate --out plate-run
  flexura run plate --without gap
  flexura run plate --until update
  flexura run plate --only focus --only report --set focus.taps=128
  flexura run plate --settings run.toml --force
"""


@click.command(name="run", epilog=EXAMPLES, short_help="Do everything, from files to the report.")
@click.argument("campaign", type=CAMPAIGN)
@click.option("--from", "first", type=STAGES, help="Begin with this stage (default: import).")
@click.option("--until", "last", type=STAGES, help="End with this stage (default: report).")
@click.option("--only", type=STAGES, multiple=True, help="This stage alone; repeat for more.")
@click.option("--without", type=STAGES, multiple=True, help="Leave this stage out; repeat for more.")
@click.option("--force", is_flag=True, help="Make again what is up to date.")
@click.option(
    "--settings",
    type=SETTINGS,
    metavar="FILE.toml",
    help="File with a table [run] of options (default: that of CAMPAIGN's campaign.toml).",
)
@click.option(
    "--set",
    "typed",
    multiple=True,
    metavar="KEY=VALUE",
    help="One option of that table, for example focus.taps=128; repeat for more.",
)
@run_out
@output_options("what run.json holds")
@bad_input
def command(
    campaign: Path,
    first: "Stage | None",
    last: "Stage | None",
    only: "tuple[Stage, ...]",
    without: "tuple[Stage, ...]",
    force: bool,
    settings: Path | None,
    typed: tuple[str, ...],
    out: Path | None,
    output: Output,
) -> None:
    """Do all stages with CAMPAIGN: import, identify, update, gap, focus, compensate, report.

    What is up to date is skipped: a result made from the same files, with the same options, by the same version.
    The others are made, and all that follows from them. Models and figures are made beside the stages where this
    computer has more than one processor. Options of stages come from a table [run] (docs/guide/command-line.md) or
    from --set. A recorded CAMPAIGN is imported into NAME-campaign beside the run folder; one that lacks sweeps is
    read where it stands.

    A stage that fails says why in one sentence; the stages that do not need it still run, and results that are
    there stay. Ctrl-C leaves finished stages whole; the same command goes on from there. Writes what the stages'
    own verbs write, and run.json: stages, seconds, SHA-256 of all inputs, options, versions. Exit status 1 where a
    stage failed or its result is not good enough, as its own verb says.

    CAMPAIGN may be running or interrupted: its finished sweeps are taken; do the same again when more are there.
    It may also be a plate with FRFs of other programs (plate.toml).
    """
    from app.chain.request import RunRequest, chosen_stages
    from app.files.campaign import not_a_campaign
    from app.files.campaign_kind import is_campaign_folder, is_recorded_campaign
    from app.files.plate_toml import declares_plate
    from app.files.run_settings import read_run_options

    if not (is_campaign_folder(campaign) or is_recorded_campaign(campaign) or declares_plate(campaign)):
        raise not_a_campaign(campaign)
    options = read_run_options(campaign, settings, typed)
    left_out = (*without, *(stage for stage in options.settings.without if stage not in only))
    try:
        stages = chosen_stages(first, last, only, left_out)
    except ValueError as error:
        raise click.UsageError(str(error)) from error

    from app.chain.run_chain import RunListener, run_chain
    from app.terminal.whole_run import closing_line, show, stage_line
    from app.terminal.worker_processes import spare_workers

    started, states = time.perf_counter(), dict[str, "StageRecord"]()

    def tell(stage: str, state: "StageRecord") -> None:
        states[stage] = state
        for note in state.notes if state.state == "made" else ():
            output.note(f"{stage}: {note}")
        if state.whole:
            output.summary(stage_line(stage, state))
        else:
            output.failure(stage_line(stage, state))

    request = RunRequest(campaign, out, stages, options, force, in_place="import" in left_out)
    record = run_chain(request, RunListener(tell, output.progress, spare_workers))
    output.result(record.record, lambda: show(record))
    output.summary(closing_line(states, request.run, time.perf_counter() - started))
    if not all(state.whole and state.good for state in states.values()):
        raise click.exceptions.Exit(1)
