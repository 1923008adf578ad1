"""``flexura run``: everything from files to the report, in one process."""

import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from app.commands.bad_input import bad_input
from app.commands.options import CAMPAIGN, Existing, engine_options, out_folder
from app.commands.output import Output, output_options

if TYPE_CHECKING:
    from app.chain.work import RunRequest
    from app.files.declarations.run_settings import Stage
    from app.files.results.run_record import StageRecord
    from app.terminal.engine import Engine

    Chosen = tuple[Stage | None, Stage | None, tuple[Stage, ...], tuple[Stage, ...]]
    """First and last stage, those alone, those left out."""

STAGES = click.Choice(["import", "identify", "update", "gap", "focus", "compensate", "report"])
SEVERAL = Existing(f"{CAMPAIGN.onward}; several of them, a folder of them, or a list (*.txt)")
SETTINGS = Existing("allowed: a TOML file with a table [run]")
EXAMPLES = """\b
Examples:
  flexura run examples/pp-plate --out plate-run
  flexura run plate --without gap
  flexura run plate --until update
  flexura run plate --only focus --only report --set focus.taps=128
  flexura run plate --settings run.toml --force
  flexura run door-1 door-2 door-3 --out doors --without gap
  flexura run campaigns --workers 4 --until focus
"""


@click.command(name="run", epilog=EXAMPLES, short_help="Do everything, from files to the report.")
@click.argument("campaign", type=SEVERAL, nargs=-1, required=True)
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
@engine_options
@out_folder("Run folder (default: NAME-run beside CAMPAIGN); of several campaigns the fleet's folder.")
@output_options("what run.json, or fleet.json, holds")
@bad_input
def command(
    campaign: tuple[Path, ...],
    first: "Stage | None",
    last: "Stage | None",
    only: "tuple[Stage, ...]",
    without: "tuple[Stage, ...]",
    force: bool,
    settings: Path | None,
    typed: tuple[str, ...],
    out: Path | None,
    engine: "Engine",
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

    Several CAMPAIGNs, a folder of them or a list (*.txt, one a line) are a fleet: all stages of each, in worker
    processes (--workers) or on a Dask cluster (--cluster), results in OUT/NAME, and one report of all, fleet.html
    and fleet.json: scatter between pieces, pieces not like the others, which filters suit which panel, laws of
    pieces measured at one temperature (docs/guide/fleets.md).
    """
    from app.files.campaigns.loading import not_a_campaign
    from app.fleet.fleet_run import is_campaign, is_fleet

    if is_fleet(campaign):
        chosen = (first, last, only, without)
        _fleet(campaign, chosen, settings, typed, out, engine, output, force=force)
        return
    (single,) = campaign
    if not is_campaign(single):
        raise not_a_campaign(single)
    if engine.named:
        raise click.UsageError("--workers and --cluster are for several campaigns: one is not spread over workers")
    _single(single, (first, last, only, without), settings, typed, out, output, force=force)


def _asked(
    campaign: Path, chosen: "Chosen", settings: Path | None, typed: tuple[str, ...], out: Path | None, force: bool
) -> "RunRequest":
    """Return what is asked of one campaign."""
    from app.chain.work import RunRequest, chosen_stages
    from app.files.declarations.run_settings import read_run_options

    first, last, only, without = chosen
    options = read_run_options(campaign, settings, typed)
    left_out = (*without, *(stage for stage in options.settings.without if stage not in only))
    try:
        stages = chosen_stages(first, last, only, left_out)
    except ValueError as error:
        raise click.UsageError(str(error)) from error
    return RunRequest(campaign, out, stages, options, force, in_place="import" in left_out)


def _single(
    campaign: Path,
    chosen: "Chosen",
    settings: Path | None,
    typed: tuple[str, ...],
    out: Path | None,
    output: Output,
    *,
    force: bool,
) -> None:
    """Run the stages of one campaign."""
    request = _asked(campaign, chosen, settings, typed, out, force)

    from app.chain.run_chain import RunListener, run_chain
    from app.terminal.engine import spare_workers
    from app.terminal.whole_run import closing_line, show, stage_line

    started, states = time.perf_counter(), dict[str, "StageRecord"]()

    def tell(stage: str, state: "StageRecord") -> None:
        states[stage] = state
        for note in state.notes if state.state == "made" else ():
            output.note(f"{stage}: {note}")
        if state.whole:
            output.summary(stage_line(stage, state))
        else:
            output.failure(stage_line(stage, state))

    record = run_chain(request, RunListener(tell, output.progress, spare_workers))
    output.result(record.record, lambda: show(record))
    output.summary(closing_line(states, request.run, time.perf_counter() - started))
    if not all(state.whole and state.good for state in states.values()):
        raise click.exceptions.Exit(1)


def _fleet(
    named: tuple[Path, ...],
    chosen: "Chosen",
    settings: Path | None,
    typed: tuple[str, ...],
    out: Path | None,
    engine: "Engine",
    output: Output,
    *,
    force: bool,
) -> None:
    """Run the stages of many campaigns, and compare them."""
    from app.files.results.run_folder import writable_folder
    from app.fleet.fleet_run import fleet_members

    members = fleet_members(named)
    folder = writable_folder(out or _beside(named), "--out").resolve()
    requests: dict[str, RunRequest] = {}
    for one in members:
        asked = _asked(one.campaign.resolve(), chosen, settings, typed, folder / one.name, force)
        here = replace(asked.options, folder=asked.options.folder.resolve())  # workers stand elsewhere
        requests[one.name] = replace(asked, options=here)

    from app.files.atomic import write_json, write_text
    from app.files.disk_room import require_room, room_of
    from app.fleet.fleet_run import MODEL_MEMORY, RunMember, run_fleet
    from app.fleet.laws_beside import exchanged, laws_beside
    from app.fleet.page import NAME, PAGE, fleet_page, fleet_record, show, summary_of
    from app.report.style import drawing

    started = time.perf_counter()
    require_room(folder, sum(room_of(one.campaign) for one in members), "--out")

    def tell(one: RunMember) -> None:
        (output.summary if one.good else output.failure)(f"{one.name}: {one.said}")

    with output.progress() as report, engine.executor(folder, MODEL_MEMORY, report, output.note) as executor:
        found = run_fleet(members, requests, executor, report, tell)
        runs = {one.name: one.run for one in found if (one.run / "laws.h5").is_file()}
        exchange = exchanged(runs, executor, report)
    laws = laws_beside(runs)
    stages = requests[members[0].name].stages
    record = fleet_record(found, laws, exchange, {"stages": list(stages), "set": list(typed)})
    write_json(folder / NAME, record)
    with drawing():
        write_text(folder / PAGE, fleet_page(found, laws, exchange))
    output.result(lambda: record, lambda: show(found, laws))
    output.summary(f"{summary_of(found, laws)}; {time.perf_counter() - started:.1f} s; report in {folder / PAGE}")
    if not all(one.good for one in found):
        raise click.exceptions.Exit(1)


def _beside(named: tuple[Path, ...]) -> Path:
    """Return the folder for a fleet's results where none is named."""
    first = named[0].resolve()
    return first.with_name(f"{first.stem}-fleet") if len(named) == 1 else first.parent / "fleet"
