"""``flexura identify``: poles and residues of a campaign, of a test, or of FRFs in a universal file."""

import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from app.commands.bad_input import bad_input
from app.commands.options import PATH, RUN_WITH_LAWS, Existing, mains, run_out
from app.commands.output import Output, output_options

if TYPE_CHECKING:
    from analysis.identification.modes import Damping
    from app.stages.identify_options import Method, Wanted

MEASURED = Existing("allowed: a campaign's folder, a test's declaration (test.toml), or a universal file")
EXAMPLES = """\b
Examples:
  flexura identify plate --out plate-run
  flexura identify plate --band 100 800 --json > modes.json
  flexura identify plate --twin plate-run
  flexura identify plate --export frfs.uff --temperature 20
  flexura identify frfs.uff --shared-poles --out plate-run
  flexura identify test.toml --out beam-run
"""


@click.command(name="identify", epilog=EXAMPLES, short_help="Find modes and follow them over temperature.")
@click.argument("campaign", metavar="CAMPAIGN|TEST.toml|FRFS.uff", type=MEASURED)
@click.option(
    "--damping",
    type=click.Choice(["hysteretic", "viscous"]),
    help="How a pole is read: viscous, |pole| and the damping ratio (default of a test and of FRFS.uff, as other "
    "programs print it), or hysteretic, sqrt(Re k) and Im k / Re k with k = -pole^2 (default of a campaign).",
)
@click.option(
    "--method",
    type=click.Choice(["auto", "peak-picking"]),
    default="auto",
    show_default=True,
    help="peak-picking is the paper's recipe: what shows no peak of its own is missed.",
)
@click.option("--band", nargs=2, type=click.FloatRange(min=0.0), metavar="LOW HIGH", help="Hz (default: all).")
@click.option("--shared-poles", is_flag=True, help="FRFS.uff: one structure, one set of poles, and its shapes.")
@click.option(
    "--export", type=PATH, metavar="FRFS.uff", help="Write CAMPAIGN's FRFs, too: .uff, .mat, .csv or .nc."
)
@click.option("--temperature", type=float, help="With --export: only the sweep nearest to it, °C (default: all).")
@click.option(
    "--actuator", metavar="ID", help="CAMPAIGN: of several that drove in turn, whose sweeps (the first)."
)
@click.option(
    "--twin",
    type=RUN_WITH_LAWS,
    metavar="RUN",
    help="Run folder of `flexura update` for CAMPAIGN: fit the modes its twin expects, under the twin's numbers.",
)
@run_out
@mains
@output_options("the modes")
@bad_input
def command(
    campaign: Path,
    damping: "Damping | None",
    method: "Method",
    band: tuple[float, float] | None,
    shared_poles: bool,
    export: Path | None,
    temperature: float | None,
    twin: Path | None,
    actuator: str | None,
    out: Path | None,
    mains: float,
    output: Output,
) -> None:
    """Find the modes in CAMPAIGN's FRFs, follow them over temperature; or those of a test, or of FRFS.uff.

    No model order, band or start value is needed: vector fitting proposes poles, variable projection moves them to
    the least-squares optimum, and BIC decides how many are kept. Every mode has standard deviations and the reason
    for its status; it is confirmed where refits of parts of the data, or sweeps at neighbouring temperatures, find
    it again. A campaign's result goes into the run folder (frf.h5, modes.h5, modes.csv), a test's too, with its
    shapes (flexura new writes TEST.toml). FRFS.uff is taken FRF by FRF and printed; with --shared-poles as one
    structure, into a run folder too.

    A CAMPAIGN may be running or interrupted: its finished sweeps are taken, and the result says how many of how
    many they are. Do the same again when more are there.
    """
    from app.files.declarations.modal_test import declares_test
    from app.files.declarations.plate import declares_plate

    if band is not None and not band[0] < band[1]:
        raise click.BadParameter(f"{band[0]:g} {band[1]:g}: LOW must be below HIGH", param_hint="--band")
    if temperature is not None and export is None:
        raise click.BadParameter(
            "chooses the sweep that --export writes; add --export", param_hint="--temperature"
        )
    # a folder with both declarations, as of a hammer test, is a test here and a plate for update
    of_campaign = not declares_test(campaign) and (campaign.is_dir() or declares_plate(campaign))
    damping = damping or ("hysteretic" if of_campaign else "viscous")
    chosen = {"damping": damping, "method": method, "band": band, "actuator": actuator}
    options = partial(_wanted, mains, temperature=temperature, **chosen)
    if actuator is not None and not of_campaign:
        raise click.BadParameter("only a campaign has actuators that drive in turn", param_hint="--actuator")
    if declares_test(campaign):
        _refuse_for_test(twin, shared_poles, export)
        _structure(campaign, out, options, output)
    elif campaign.suffix.lower() in (".uff", ".unv", ".uf") or (
        campaign.is_file() and campaign.suffix.lower() != ".toml"
    ):
        _refuse_for_universal(twin, shared_poles, export, out)
        if shared_poles:
            _structure(campaign, out, options, output)
        else:
            _uff(campaign, options, output)
    else:
        if shared_poles:
            raise click.BadParameter("a campaign's sensors always share poles", param_hint="--shared-poles")
        if twin is not None and method != "auto":
            raise click.BadParameter("the paper's recipe uses no twin; leave --method out", param_hint="--twin")
        _campaign(campaign, out, export, twin, options, output)


def _refuse_for_test(twin: Path | None, shared_poles: bool, export: Path | None) -> None:
    """Refuse options that a modal test does not have."""
    if twin is not None:
        raise click.BadParameter("a test has no twin", param_hint="--twin")
    if shared_poles or export is not None:
        message = "a test's FRFs always share poles; they are written as RUN/frfs.uff"
        raise click.BadParameter(message, param_hint="--shared-poles" if shared_poles else "--export")


def _refuse_for_universal(twin: Path | None, shared_poles: bool, export: Path | None, out: Path | None) -> None:
    """Refuse options that a universal file does not have."""
    if export is not None:
        raise click.BadParameter("the FRFs are in a universal file already", param_hint="--export")
    if twin is not None:
        raise click.BadParameter("a universal file has no twin", param_hint="--twin")
    if out is not None and not shared_poles:
        message = "FRFs identified one by one are only printed; a run folder needs --shared-poles"
        raise click.BadParameter(message, param_hint="--out")


def _wanted(mains: float, **options: Any) -> "Wanted":
    """Return the options for the stage; called after the input is read, because importing the stage is slow."""
    from analysis.identification.settings import Settings
    from app.stages.identify_options import Wanted

    return Wanted(Settings(mains=mains), **options)


def _campaign(
    campaign: Path,
    out: Path | None,
    export: Path | None,
    twin: Path | None,
    options: "Callable[[], Wanted]",
    output: Output,
) -> None:
    """Identify and track a campaign; write frf.h5, modes.h5 and modes.csv, and its FRFs if `export` is given."""
    from app.files.campaigns.kind import EXPORTS
    from app.files.campaigns.loading import load_campaign
    from app.files.disk_room import room_of
    from app.files.results.run_folder import run_file, run_folder, writable_folder

    started = time.perf_counter()
    if twin is not None:
        run_file(twin, "laws.h5", "update")
    loaded = load_campaign(campaign)

    from app.files.campaigns.of_run import remember_campaign
    from app.stages import identify
    from app.summaries.modes import campaign_record, summary, tables
    from app.summaries.numbers import extent_record, led
    from app.terminal.tables import show

    wanted = options()
    if export is not None:
        writable_folder(export.parent, "--export")
        if export.suffix.lower() not in EXPORTS:
            raise click.BadParameter(f"{export}: allowed endings: {', '.join(EXPORTS)}", param_hint="--export")
    with run_folder(campaign, out, room_of(campaign)) as run, output.progress() as report:
        found = identify.compute(loaded, wanted, report, twin)
        identify.save(run, loaded, found, wanted, export)
        remember_campaign(run, campaign)
    tracked = found.tracked
    seconds = time.perf_counter() - started
    record = campaign_record(tracked, seconds) | extent_record(loaded.extent)
    output.result(lambda: record, lambda: show(tables(tracked)))
    said = () if export is None else (identify.said_of_export(export, found, wanted.temperature),)
    for note in (*found.frf.notes, *tracked.notes, *said):
        output.note(note)
    output.summary(f"{led(loaded.extent)}{summary(tracked, seconds)}; results in {run}")
    if not any(modes.real.any() for modes in tracked.modes):
        raise click.exceptions.Exit(1)


def _structure(path: Path, out: Path | None, options: "Callable[[], Wanted]", output: Output) -> None:
    """Identify a test, or the FRFs of a universal file, as one structure."""
    from app.files.results.run_folder import run_folder
    from app.modal_test.declared_test import frfs_of_file

    started = time.perf_counter()
    typed_mains = click.get_current_context().get_parameter_source("mains") is ParameterSource.COMMANDLINE
    folder = path.parent if path.name == "test.toml" else path
    with run_folder(folder, out) as run, output.progress() as report:
        frfs = frfs_of_file(path, report)

        from app.modal_test.modes_of_test import record_of, shape_tables
        from app.stages import identify_structure as stage
        from app.summaries.modes import mode_table, modes_record
        from app.terminal.tables import show

        found, wanted = stage.compute(frfs, options(), report, mains_named=typed_mains)
        stage.save(run, found, wanted)
    frfs, seconds = found.frfs, time.perf_counter() - started

    output.result(
        lambda: record_of(found, seconds),
        lambda: show([mode_table(frfs.title, modes_record(found.modes)["modes"]), *shape_tables(found)]),
    )
    for note in frfs.notes:
        output.note(note)
    if wanted.settings.mains not in (None, 50.0) and frfs.mains is None and not typed_mains:
        output.note(f"mains hum at odd multiples of {wanted.settings.mains:g} Hz: taken as the mains frequency")
    count, sure = int(found.modes.real.sum()), found.modes.confirmation.count("confirmed")
    output.summary(
        f"{len(frfs.transfers)} FRFs, {count} modes ({sure} confirmed) at {len(found.shapes.places)} places in "
        f"{seconds:.1f} s, misfit {100 * found.modes.misfit:.2f} %; results in {run}"
    )
    if count == 0:
        raise click.exceptions.Exit(1)


def _uff(path: Path, options: "Callable[[], Wanted]", output: Output) -> None:
    """Identify the FRFs of a universal file one by one, and print their modes."""
    from app.files.uff.frfs import read_frfs

    started = time.perf_counter()
    frfs = read_frfs(path)

    from app.stages.identify import uff_records
    from app.summaries.modes import mode_table
    from app.terminal.tables import show

    with output.progress() as report:
        records = uff_records(frfs, options(), report)
    seconds = time.perf_counter() - started

    output.result(
        lambda: {"frfs": records, "seconds": seconds},
        lambda: show(mode_table(str(record["name"]), record["modes"]) for record in records),
    )
    for record in records:
        if "note" in record:
            output.note(f"{record['name']}: {record['note']}")
    found = sum(len(record["modes"]) for record in records)
    output.summary(f"{len(records)} FRFs, {found} modes in {seconds:.1f} s")
    if found == 0:
        raise click.exceptions.Exit(1)
