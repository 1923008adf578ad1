"""``flexura export``: filters in the formats of other programs."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from app.commands.bad_input import bad_input
from app.commands.options import RUN_WITH_FILTERS, following_method, out_folder
from app.commands.output import Output, output_options

if TYPE_CHECKING:
    from app.files.exports.c_code import Cost
    from app.files.exports.shipment import Shipment

FORMS = ("c", "onnx", "npz", "wav", "csv", "tdms", "mat", "uff")
OF_SWEEPS = ("tdms", "mat", "csv", "uff")
"""Forms of a campaign's raw sweeps."""


class _PrefixName(click.ParamType[str]):
    """A word that C takes at the beginning of a name."""

    name = "name"

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> str:
        from app.files.exports.c_code import PREFIXES

        if not re.fullmatch(PREFIXES, value):
            self.fail(
                f"{value!r}: a small letter, then at most 30 small letters, digits and underscores", param, ctx
            )
        return value


PREFIX_NAME = _PrefixName()

EXAMPLES = """\b
Examples:
  flexura export plate-run --to c
  flexura export plate-run --to c --number int16 --out firmware
  flexura export plate-run --to c --number int16 --example --out firmware
  flexura export car-run --to c --tilt --out firmware
  flexura export rear-run --to c --prefix rear_door --out firmware
  flexura export plate-run --to wav --temperature 20 --temperature 45
  flexura export my-campaign --to tdms --out for-labview
"""


@click.command(name="export", epilog=EXAMPLES, short_help="Write filters, or raw sweeps, for other programs.")
@click.argument("run", metavar="[RUN|CAMPAIGN]", type=RUN_WITH_FILTERS, required=False)
@click.option("--to", "form", type=click.Choice(FORMS), required=True, help="What is written.")
@following_method
@click.option(
    "--number",
    type=click.Choice(("float32", "int16")),
    default="float32",
    show_default=True,
    help="Numbers of the C code.",
)
@click.option(
    "--prefix",
    type=PREFIX_NAME,
    help="First word of names in the C code and of its files: several panels fit one program.  [default: flexura]",
)
@click.option(
    "--example",
    is_flag=True,
    help="With int16: buffers for a serial audio port fed by DMA, and a loop-back check against a rendered file.",
)
@click.option(
    "--tilt",
    is_flag=True,
    help="C code that follows several thermometers; after flexura compensate --weather.",
)
@click.option(
    "--temperature",
    "temperatures",
    type=float,
    multiple=True,
    help="°C, for npz, wav and csv; repeat for more (default: every 5 °C).",
)
@out_folder("Folder for the files (default: RUN; of sweeps NAME-FORM beside CAMPAIGN).")
@output_options("files, bytes and operations")
@bad_input
def command(
    run: Path | None,
    form: str,
    method: str | None,
    number: str,
    prefix: str | None,
    example: bool,
    tilt: bool,
    temperatures: tuple[float, ...],
    out: Path | None,
    output: Output,
) -> None:
    """Write the filters of RUN so that other programs run them.

    RUN is a run folder with compensation.h5 (of flexura compensate) or filters.h5 (of flexura focus), the current
    folder unless given. c: a C99 header and one file that allocate nothing, with the update for a new temperature
    (with --tilt for the readings of several thermometers) and the convolution. onnx: temperature in, taps out. npz
    and csv: taps at some temperatures, npz with all that gives them at any other. wav: impulse responses, a file
    per temperature. Every file says what it was made from.

    Of a CAMPAIGN, recorded, imported or acquired, the raw sweeps are written, a file each: tdms, as flexura import
    reads them; mat; csv; uff, time responses of universal files. Of one that is running or was interrupted, those
    that are finished.
    """
    if run is not None and _is_campaign(run):
        given = {"--method": method, "--prefix": prefix, "--example": example, "--temperature": temperatures}
        given["--tilt"] = tilt
        given["--number"] = None if number == "float32" else number
        _sweeps(run, form, given, out, output)
        return
    _refuse_tests(run or Path())
    if form not in FORMS[:5]:
        raise click.UsageError(f"--to {form} is for the sweeps of a campaign; {run or Path()} holds none")
    if number == "int16" and form != "c":
        raise click.UsageError(f"--number int16 is for --to c; {form} holds floats")
    if example and (form != "c" or number != "int16"):
        raise click.UsageError("--example is of 16-bit samples: it needs --to c --number int16")
    if tilt and form != "c":
        raise click.UsageError(f"--tilt is for --to c; {form} holds filters of panels without a tilt")
    if prefix is not None and form != "c":
        raise click.UsageError(f"--prefix is for --to c; {form} has no names")
    if temperatures and form in ("c", "onnx"):
        raise click.UsageError(f"--temperature is for npz, wav and csv; {form} follows every temperature")
    from analysis.rendering.following import TiltBank
    from app.files.exports.c_code import SAMPLES_AT_ONCE, Cost
    from app.files.exports.shipment import shipment
    from app.files.exports.written_filters import export_temperatures, same_names, write_filters
    from app.files.results.run_folder import run_folder

    beside = run or Path()
    sent = shipment(beside, method, "export").chosen(
        {"to": form, "number": number, **({"tilt": True} if tilt else {})}
    )
    wanted = export_temperatures(sent, temperatures, "--temperature")
    if form == "wav" and same_names(wanted):
        raise click.UsageError("--temperature: two of them are the same to 0.01 °C, as in the names of WAV files")
    cost = None
    if form == "c":
        tilted = TiltBank.of(sent.in_weather()[0]) if tilt else None
        thermometers = len(sent.in_weather()[1].names) if tilt else 0
        cost = Cost.of(sent.filters, number == "int16", SAMPLES_AT_ONCE, tilted, thermometers)
    with run_folder(beside, out or beside) as folder:
        written = write_filters(
            sent, form, folder, wanted, number=number, prefix=prefix, example=example, tilt=tilt
        )
    output.result(lambda: record(sent, written, cost))
    for note in sent.notes:
        output.note(note)
    if form == "c" and sent.family is not None and not tilt:
        output.note("the filters of the tilt are left out, the code follows one temperature; --tilt writes them")
    output.summary(summary(sent, written, cost))


def _refuse_tests(folder: Path) -> None:
    """Say how other programs get what a hammer test, or the run of a modal test, holds."""
    from app.files.bad_file import quoted
    from app.files.campaigns.kind import is_hammer_folder
    from app.files.results.run_folder import is_test_run

    if is_test_run(folder) and not (folder / "filters.h5").is_file():
        there = [name for name in ("frfs.uff", "modes.uff", "modes.csv") if (folder / name).is_file()]
        raise click.UsageError(
            f"{folder} is the run of a modal test, with neither filters nor sweeps; FRFs and modes for other "
            f"programs lie there: {', '.join(there) or 'none; flexura identify writes them'}"
        )
    if is_hammer_folder(folder):
        raise click.UsageError(
            f"{folder} is a hammer test, with neither filters nor sweeps; its FRFs, as universal files: "
            f"flexura identify {quoted(folder)}"
        )


def _is_campaign(folder: Path) -> bool:
    from app.files.campaigns.kind import is_campaign_folder, is_recorded_campaign

    return is_campaign_folder(folder) or is_recorded_campaign(folder)


def _sweeps(campaign: Path, form: str, given: Mapping[str, object], out: Path | None, output: Output) -> None:
    """Write the raw sweeps of a campaign."""
    if form not in OF_SWEEPS:
        raise click.UsageError(f"--to {form} is for filters; sweeps of a campaign: {', '.join(OF_SWEEPS)}")
    wrong = next((name for name, value in given.items() if value), None)
    if wrong is not None:
        raise click.UsageError(f"{wrong} is for filters; {campaign} holds sweeps")
    from analysis.recordings.campaign import Campaign
    from app.files.campaigns.loading import load_campaign
    from app.files.campaigns.sweeps_out import write_sweeps
    from app.files.results.run_folder import writable_folder
    from app.summaries.numbers import led

    loaded = load_campaign(campaign)
    if not isinstance(loaded, Campaign):
        raise click.UsageError(f"{campaign} holds FRFs and no sweeps; flexura identify --export writes FRFs")
    folder = out or campaign.resolve().with_name(f"{campaign.resolve().name}-{form}")
    writable_folder(folder, "--out")
    with output.progress() as report:
        written = write_sweeps(loaded, folder, form, report)
    total = sum(path.stat().st_size for path in written)
    output.result(lambda: {"files": [str(path) for path in written], "bytes": total, "sweeps": len(loaded.sweeps)})
    output.summary(f"{led(loaded.extent)}{len(loaded.sweeps)} sweeps in {folder}, {total / 1e6:.1f} MB")


def record(sent: "Shipment", written: tuple[Path, ...], cost: "Cost | None") -> dict[str, Any]:
    """Return what ``--json`` prints.

    Parameters
    ----------
    written : tuple of Path
        Its files.
    cost : Cost or None
        On the target; None for formats that are no program.

    Returns
    -------
    dict
        Of JSON values.
    """
    _, weights, taps = sent.filters.banks.shape
    low, high = sent.filters.temperature_range
    found: dict[str, Any] = {
        "files": [str(path) for path in written],
        "bytes": sum(path.stat().st_size for path in written),
        "method": sent.method,
        "actuators": list(sent.names),
        "taps": taps,
        "banks": weights,
        "sample_rate_hz": sent.filters.sample_rate,
        "delay_samples": sent.filters.delay,
        "temperature_range_c": [low, high],
    }
    if cost is not None:
        found["target"] = {
            "constant_bytes": cost.constant_bytes,
            "state_bytes": cost.state_bytes,
            "multiply_adds_per_update": cost.update_operations,
            "multiply_adds_per_sample": cost.sample_operations,
        }
    return found


def summary(sent: "Shipment", written: tuple[Path, ...], cost: "Cost | None") -> str:
    """Return a summary in one line.

    Parameters
    ----------
    written : tuple of Path
        Its files, at least one.
    cost : Cost or None
        On the target; None for formats that are no program.
    """
    actuators, _, taps = sent.filters.banks.shape
    low, high = sent.filters.temperature_range
    span = f"{low:g} to {high:g} °C" if low < high else f"{low:g} °C"
    what = f"{sent.method}, {actuators} filters of {taps} taps, {span}"
    if cost is not None:
        what += (
            f"; on the target {cost.constant_bytes / 1e3:.1f} kB constant, {cost.state_bytes / 1e3:.1f} kB RAM, "
            f"{cost.update_operations} multiply-adds an update, {cost.sample_operations} a sample "
            f"({cost.sample_operations * sent.filters.sample_rate / 1e6:.0f} million a second)"
        )
    return f"{what}; {written[0] if len(written) == 1 else f'{len(written)} files in {written[0].parent}'}"
