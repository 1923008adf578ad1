"""``flexura identify``: poles and residues of a campaign or of FRFs in a universal file."""

import time
from pathlib import Path
from typing import TYPE_CHECKING

import click

from app.commands.bad_input import bad_input
from app.commands.options import PATH, mains, run_out
from app.commands.output import Output, output_options

if TYPE_CHECKING:
    from analysis.identification.reading import Damping
    from app.identification import Wanted


EXAMPLES = """\b
Examples:
  flexura identify plate --out plate-run
  flexura identify plate --band 100 800 --json > modes.json
  flexura identify plate --twin plate-run
  flexura identify frfs.uff --shared-poles --damping viscous
"""


@click.command(name="identify", epilog=EXAMPLES, short_help="Find modes and follow them over temperature.")
@click.argument("campaign", metavar="CAMPAIGN|FRFS.uff", type=PATH)
@click.option(
    "--damping",
    type=click.Choice(["hysteretic", "viscous"]),
    default="hysteretic",
    show_default=True,
    help="How a pole is read: sqrt(Re k) and Im k / Re k with k = -pole^2, or |pole| and twice the damping ratio.",
)
@click.option(
    "--method",
    type=click.Choice(["auto", "peak-picking"]),
    default="auto",
    show_default=True,
    help="peak-picking is the paper's recipe: what shows no peak of its own is missed.",
)
@click.option("--band", nargs=2, type=click.FloatRange(min=0.0), metavar="LOW HIGH", help="Hz (default: all).")
@click.option("--shared-poles", is_flag=True, help="FRFs.uff: one set of poles for all FRFs of the file.")
@click.option("--export", type=PATH, metavar="FRFS.uff", help="Write CAMPAIGN's FRFs as a universal file, too.")
@click.option(
    "--twin",
    type=PATH,
    metavar="RUN",
    help="Run folder of `flexura update` for CAMPAIGN: fit the modes its twin expects, under the twin's numbers.",
)
@run_out
@mains
@output_options("the modes")
@bad_input
def command(
    campaign: Path,
    damping: "Damping",
    method: str,
    band: tuple[float, float] | None,
    shared_poles: bool,
    export: Path | None,
    twin: Path | None,
    out: Path | None,
    mains: float,
    output: Output,
) -> None:
    """Find the modes in CAMPAIGN's FRFs, follow them over temperature; or those of FRFS.uff, FRF by FRF.

    No order, no band and no start value is asked for: vector fitting proposes, variable projection moves the
    poles to the least-squares optimum, BIC decides how many stay, and every mode carries its standard deviations
    and the reason for its status. A campaign's result goes into the run folder (frf.h5, modes.h5, modes.csv).
    """
    from analysis.identification.automatic import Settings
    from app.identification import Wanted

    if band is not None and not band[0] < band[1]:
        raise click.BadParameter(f"{band[0]:g} {band[1]:g}: LOW must be below HIGH", param_hint="--band")
    wanted = Wanted(Settings(mains=mains), damping, method, band)
    suffix = campaign.suffix.lower()
    if suffix in (".uff", ".unv", ".uf") or (campaign.is_file() and suffix != ".toml"):
        if out is not None:
            raise click.BadParameter("a universal file's modes are only printed; use --json", param_hint="--out")
        if export is not None:
            raise click.BadParameter("the FRFs are in a universal file already", param_hint="--export")
        if twin is not None:
            raise click.BadParameter("a universal file has no twin", param_hint="--twin")
        identify_uff(campaign, wanted, shared_poles, output)
    else:
        if shared_poles:
            raise click.BadParameter("a campaign's sensors always share poles", param_hint="--shared-poles")
        if twin is not None and method != "auto":
            raise click.BadParameter("the paper's recipe knows no twin; leave --method out", param_hint="--twin")
        identify_campaign(campaign, out, export, twin, wanted, output)


def identify_campaign(
    campaign: Path, out: Path | None, export: Path | None, twin: Path | None, wanted: "Wanted", output: Output
) -> None:
    """Identify and track a campaign; write frf.h5, modes.h5 and modes.csv, and its FRFs for others where asked."""
    from analysis.frf import campaign_frf
    from analysis.identification.tracking import track
    from app.expected_modes import expected_modes
    from app.files.bad_file import ResultFileError
    from app.files.campaign import load_campaign
    from app.files.frf_file import save_frf
    from app.files.modes_file import save_modes, write_table
    from app.files.provenance import provenance, sha256
    from app.files.run_folder import run_folder
    from app.mode_records import campaign_record, show

    started = time.perf_counter()
    loaded = load_campaign(campaign)
    run = run_folder(campaign, out)
    with output.progress() as report:
        try:
            frf = campaign_frf(loaded, mains=wanted.settings.mains or 50.0)
            expected = None if twin is None else expected_modes(loaded, twin / "laws.h5", report)
            tracked = track(wanted.cut(frf), wanted.settings, report, wanted.one_by_one(), expected)
        except ValueError as error:  # a silent sensor, a band with no lines
            raise ResultFileError(f"{campaign}: {error}") from error
    inputs = loaded.hashes if twin is None else {**loaded.hashes, "laws.h5": sha256(twin / "laws.h5")}
    made_from = provenance(inputs, {"campaign": loaded.name} | wanted.record())
    save_frf(run / "frf.h5", loaded.experiment, frf, made_from)
    if export is not None:
        from app.files.uff58 import write_frfs
        from app.files.uff_campaign import campaign_frfs

        write_frfs(export, campaign_frfs(loaded.experiment, frf))
    save_modes(run / "modes.h5", tracked, made_from)
    write_table(run / "modes.csv", tracked, wanted.damping)
    seconds = time.perf_counter() - started
    output.result(lambda: campaign_record(tracked, wanted.damping, seconds), lambda: show(tracked, wanted.damping))
    for note in (*frf.notes, *tracked.notes):
        output.note(note)
    counts = [int(modes.real.sum()) for modes in tracked.modes]
    output.summary(
        f"{len(counts)} sweeps, {min(counts)} to {max(counts)} modes each in {seconds:.1f} s, misfit at most "
        f"{100 * tracked.misfit.max():.2f} %; results in {run}"
    )


def identify_uff(path: Path, wanted: "Wanted", shared_poles: bool, output: Output) -> None:
    """Identify the FRFs of a universal file and print their modes; exit status 1 where none is found."""
    from app.files.uff58 import read_frfs
    from app.identification import shared_records, uff_records
    from app.mode_records import show_modes

    started = time.perf_counter()
    frfs = read_frfs(path)
    with output.progress() as report:
        records = shared_records(path, frfs, wanted, report) if shared_poles else uff_records(frfs, wanted, report)
    seconds = time.perf_counter() - started

    def show_all() -> None:
        for record in records:
            show_modes(str(record["name"]), record["modes"])

    output.result(
        lambda: {"frfs": records, "seconds": seconds},
        show_all,
    )
    for record in records:
        if "note" in record:
            output.note(f"{record['name']}: {record['note']}")
    found = sum(len(record["modes"]) for record in records)
    output.summary(f"{len(records)} FRFs, {found} modes in {seconds:.1f} s")
    if found == 0:
        raise click.exceptions.Exit(1)
