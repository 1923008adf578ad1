"""``flexura new``: a declaration to start from."""

import sys
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from app.commands.bad_input import bad_input
from app.commands.options import Existing, out_folder
from app.commands.output import Output, output_options
from app.files.bad_file import quoted

if TYPE_CHECKING:
    from app.modal_test.guessed_channels import NewTest


EXAMPLES = """\b
Examples:
  flexura new test hits.csv --kind hammer --drive "Hammer=2.25 mV/N" --response "Acc=100 mV/g"
  flexura new test point*.csv --roving Hammer --drive "Hammer=2.25 mV/N" --response "Acc=100 mV/g"
  flexura new test frfs.mat --frf-units mm/s N --points points.csv
  flexura new plate frfs/*.uff --plate 0.4 0.3 0.003 0.33 --out my-plate
  flexura new campaign --plate 0.4 0.3 0.003 0.33 --out my-plate
  flexura new experiment --plate 0.3 0.2 0.003 0.16 --oven watlow-f4t --port /dev/ttyUSB0
  flexura new experiment --kind hammer --plate 0.3 0.2 0.003 0.16
  flexura new panel --plate 0.3 0.2 0.003 0.16 --out door.toml
  flexura new campaign my-plate/sweeps/*.tdms --drive Voltage_0 --unused Room --out my-plate
"""


def _named(_: click.Context, __: click.Parameter, values: tuple[str, ...]) -> dict[str, str | None]:
    """Split ``NAME=UNIT``."""
    parts = (value.partition("=") for value in values)
    return {name.strip(): sensitivity.strip() or None for name, _, sensitivity in parts}


def write_plate(
    files: tuple[Path, ...],
    plate: tuple[float, float, float, float] | None,
    units: tuple[str, str] | None,
    points: Path | None,
    title: str,
    folder: Path,
    output: Output,
) -> None:
    """Write the declaration of a plate and print what is to be completed in it.

    Parameters
    ----------
    plate : (float, float, float, float) or None
    units : (str, str) or None
    title : str
        These four as in `app.plate_frfs.new_plate.SaidOfPlate`.
    folder : Path
        Or the declaration's name.
    """
    from app.plate_frfs.new_plate import SaidOfPlate, new_plate

    declaration, missing, notes = new_plate(files, SaidOfPlate(plate, units, points, title), folder)
    output.result(lambda: {"declaration": str(declaration), "missing": missing, "notes": notes})
    named = declaration.parent if declaration.name == "plate.toml" else declaration
    for note in notes:
        output.note(note)
    if missing:
        output.note(f"to be completed, each a line that begins with #: {', '.join(missing)}")
    first = "complete it" if missing else "check it"
    output.summary(f"{declaration}: {first}, then: flexura update {quoted(named)}")


class PlateNumber(click.FloatRange):
    """One number of --plate; all four are named where an option stands in the place of one."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number."""
        if isinstance(value, str) and value.startswith("--"):
            self.fail("four numbers are wanted, LX LY THICKNESS MASS; one is missing", param, ctx)
        return super().convert(value, param, ctx)


@click.command(name="new", epilog=EXAMPLES, short_help="Write a declaration to start from.")
@click.argument("what", type=click.Choice(["test", "campaign", "plate", "experiment", "panel"]))
@click.argument("files", nargs=-1, type=Existing("allowed: files of signals or FRFs"))
@click.option(
    "--kind",
    type=click.Choice(["hammer", "continuous", "frf"]),
    help="Of a test: hits, a continuous signal, or FRFs (default: by its channels). Of an experiment: hammer, for "
    "one in which hits are recorded.",
)
@click.option("--drive", multiple=True, callback=_named, metavar="NAME=UNIT", help="Drives; unit or sensitivity.")
@click.option("--response", multiple=True, callback=_named, metavar="NAME=UNIT", help="Answers; * for several.")
@click.option("--unused", multiple=True, metavar="NAME", help="A channel that is neither.")
@click.option(
    "--rate", type=click.FloatRange(min=0.0, min_open=True), help="Sample rate, Hz (default: the files')."
)
@click.option(
    "--roving",
    metavar="NAME",
    help="A channel that was moved: at the node of each file's name (point3, p3_hit2), else at 1, 2, ... in turn.",
)
@click.option("--same-point", is_flag=True, help="All FILES are of the same points, whatever they are called.")
@click.option(
    "--points",
    type=Existing("allowed: a CSV file"),
    metavar="POINTS.csv",
    help="Places of the nodes: number, x, y, z in m.",
)
@click.option("--frf-units", nargs=2, metavar="RESPONSE REFERENCE", help="Of FRFs (default: m/s2 N).")
@click.option("--title", default="", help="Of the report (default: the folder's name).")
@click.option(
    "--plate",
    nargs=4,
    type=PlateNumber(min=0.0, min_open=True),
    metavar="LX LY THICKNESS MASS",
    help="Of all but a test: m and kg.",
)
@click.option("--oven", metavar="KIND", help="Of an experiment: its controller, such as watlow-f4t.")
@click.option(
    "--port", help="Of an experiment: where its oven is reached, COM3, /dev/ttyUSB0, socket://HOST:PORT."
)
@out_folder("Folder of the declaration, or its name ending in .toml (default: beside FILES, or here).")
@output_options("what was declared")
@bad_input
def command(
    what: str,
    files: tuple[Path, ...],
    kind: str | None,
    drive: dict[str, str | None],
    response: dict[str, str | None],
    unused: tuple[str, ...],
    rate: float | None,
    roving: str | None,
    same_point: bool,
    points: Path | None,
    frf_units: tuple[str, str] | None,
    title: str,
    plate: tuple[float, float, float, float] | None,
    oven: str | None,
    port: str | None,
    out: Path | None,
    output: Output,
) -> None:
    """Write a declaration to start from: test.toml, campaign.toml, plate.toml, experiment.toml or panel.toml.

    FILES hold the signals or FRFs of a test; of a campaign they are TDMS files in a recorder's own layout, one per
    sweep, or none for Flexura's layout. Channels are taken from the first file, and their roles are guessed if not
    given. Test channels in volts need a sensitivity; at a terminal you are asked for it. The declaration is yours
    to correct; flexura identify, or flexura import, reads it. Of a plate FILES hold FRFs of other programs, in
    any format of a test, or are a test.toml or frf.h5; what they do not say is left as lines to complete. Verbs
    that take a campaign take its folder. An experiment gets the terminals and the port of the devices that are
    connected to this computer; at a terminal you are asked for plate and oven.
    """
    known = Counter(one.resolve() for one in files)
    for one in files:
        if known[one.resolve()] > 1:
            raise click.BadParameter(f"{one} is named twice; each file once", param_hint="FILES")
    if what != "experiment":
        _refuse("belongs to an experiment", {"--oven": oven, "--port": port})
    of_tests: dict[str, object] = {"--kind": kind, "--rate": rate, "--roving": roving, "--same-point": same_point}
    _require_plate(plate)
    channels: dict[str, object] = {"--drive": drive, "--response": response, "--unused": unused}
    of_frfs: dict[str, object] = {"--points": points, "--frf-units": frf_units}
    if what in ("experiment", "panel"):
        hammer = what == "experiment" and kind == "hammer"
        if hammer:
            of_tests = {name: value for name, value in of_tests.items() if name != "--kind"}
            _refuse(
                "of a hammer test is written into its file, with [set_points]", {"--oven": oven, "--port": port}
            )
        _refuse(f"does not belong to a new {what}", of_tests | channels | of_frfs | {"FILES": files})
        _from_nothing("hammer test" if hammer else what, plate, title, oven, port, out or Path(), output)
        return
    if what == "plate":
        _refuse("belongs to a test; of a plate channels are declared in plate.toml", of_tests | channels)

        beside = files[0].parent if files else Path()
        write_plate(files, plate, frf_units, points, title, out or beside, output)
        return
    if what == "campaign":
        _refuse("belongs to a test; in a campaign it is declared in campaign.toml", of_tests | of_frfs)
        if not files:
            _refuse("names a channel of the recorder's TDMS files: name these, too", channels)
        beside = files[0].parent if files else Path()
        beside = beside.resolve().parent if beside.resolve().name == "sweeps" else beside
        _campaign(files, (drive, response, unused), title, plate, out or beside, output)
        return
    _refuse("belongs to a campaign; a test has --points POINTS.csv for its nodes", {"--plate": plate})

    from app.files.declarations.modal_test import NAME
    from app.modal_test.guessed_channels import NewTest

    folder = out or (files[0].parent if files else Path())
    target = folder if folder.suffix == ".toml" else folder / NAME
    if target.exists():
        raise click.BadParameter(f"{target} is there already; name another or remove it", param_hint="--out")
    said = NewTest(kind, drive, response, unused, title, rate, roving, points, frf_units, same_point)
    _test(files, said, target, output)


def _require_plate(plate: tuple[float, float, float, float] | None) -> None:
    """Refuse dimensions that no declaration may have, such as mm for m, before one is written with them."""
    if plate is None:
        return
    from analysis.declaration.plate import Plate
    from app.files.campaign_error import CampaignFileError
    from app.files.settings_toml import checked

    table = dict(zip(("length_x", "length_y", "thickness", "mass"), plate, strict=True))
    try:
        checked(Path("--plate"), table, Plate)
    except CampaignFileError as error:
        said = [str(replace(one, file="")) for one in error.problems]
        raise click.BadParameter("; ".join(said), param_hint="--plate") from error


def _from_nothing(
    what: str,
    plate: tuple[float, float, float, float] | None,
    title: str,
    oven: str | None,
    port: str | None,
    out: Path,
    output: Output,
) -> None:
    """Write an experiment or a panel; at a terminal, ask for what was not said."""
    from app.rig.new_declarations import NewExperiment, new_experiment, new_hammer_experiment, new_panel

    target = out if out.suffix == ".toml" else out / f"{what.replace(' ', '-')}.toml"
    if sys.stdin.isatty() and not output.quiet:
        if plate is None:
            names = ("length along x, m", "length along y, m", "thickness, m", "mass, kg")
            usual = (0.24, 0.19, 0.003, 0.12996)
            asked = click.FloatRange(min=0.0, min_open=True)
            lx, ly, thickness, mass = (
                click.prompt(f"plate: {name}", default=value, type=asked, err=True)
                for name, value in zip(names, usual, strict=True)
            )
            plate = (lx, ly, thickness, mass)
            _require_plate(plate)
        if what == "experiment" and oven is None:
            oven = click.prompt("oven: kind of controller", default="eurotherm-2400", err=True)
    if what == "experiment":
        missing = new_experiment(target, NewExperiment(plate, title, oven, port))
    elif what == "hammer test":
        missing = new_hammer_experiment(target, NewExperiment(plate, title))
    else:
        missing = new_panel(target, plate, title)
    output.result(lambda: {"declaration": str(target), "missing": missing})
    for one in missing:
        output.note(one)
    onward = {"experiment": f"doctor {quoted(target)}", "hammer test": f"acquire {quoted(target)} --rig simulated"}
    then = onward.get(what, f"focus RUN --panel {quoted(target)}")
    output.summary(f"{target}: complete it, then: flexura {then}")


def _campaign(
    files: tuple[Path, ...],
    channels: tuple[dict[str, str | None], dict[str, str | None], tuple[str, ...]],
    title: str,
    plate: tuple[float, float, float, float] | None,
    folder: Path,
    output: Output,
) -> None:
    """Write the declaration of a campaign and print what is missing in it."""
    from app.modal_test.guessed_channels import NewTest
    from app.modal_test.new_declaration import new_campaign

    declaration, missing = new_campaign(folder, plate, title, files, NewTest(None, *channels))
    output.result(lambda: {"declaration": str(declaration), "missing": missing})
    for one in missing:
        output.note(one)
    output.summary(
        f"{declaration}: put your plate, patches, protocol into it, then: "
        f"flexura import {quoted(declaration.parent)}"
    )


def _test(files: tuple[Path, ...], options: "NewTest", target: Path, output: Output) -> None:
    """Write the declaration of a modal test; at a terminal, ask for the sensitivities that are missing."""
    from app.modal_test.new_declaration import PlacesUnknownError, new_test

    try:
        declared, missing = new_test(files, options, target)
    except PlacesUnknownError as unknown:
        if not sys.stdin.isatty() or output.quiet:
            raise
        asked = f"{files[0].name} to {files[-1].name}: which channel was moved from point to point"
        moved = click.prompt(asked, type=click.Choice([*unknown.channels, "none"]), err=True)
        answer = {"same_point": True} if moved == "none" else {"roving": moved}
        options = replace(options, **answer)
        declared, missing = new_test(files, options, target)
    if missing and sys.stdin.isatty() and not output.quiet:
        given = {n: click.prompt(f"sensitivity of {n}, such as 100 mV/g", err=True) for n in missing}
        roles = {name: declared.channels[name].role for name in missing}
        drives: dict[str, str | None] = {name: value for name, value in given.items() if roles[name] == "drive"}
        others: dict[str, str | None] = {name: value for name, value in given.items() if roles[name] == "response"}
        complete = replace(options, drives=options.drives | drives, responses=options.responses | others)
        declared, missing = new_test(files, complete, target)
    channels = {name: channel.role for name, channel in declared.channels.items()}
    output.result(lambda: {"declaration": str(target), "kind": declared.kind, "channels": channels})
    for name, lacks in missing.items():
        output.note(f"channel {name!r} {lacks} (in {target})")
    groups = sum(1 for record in declared.record if record.group)
    if groups:
        output.note(f"{groups} groups of channels, each a [[record]]: delete in {target} what is no hit or run")
    moved = ""
    if options.roving:
        nodes = {record.at[options.roving] for record in declared.record}
        moved = f", {options.roving} at {len(nodes)} points in {len(declared.record)} records"
    output.summary(
        f"{target}: {declared.kind}, {len(channels)} channels{moved}; then: flexura identify {quoted(target)}"
    )


def _refuse(why: str, options: Mapping[str, object]) -> None:
    """Refuse options that do not apply to the kind of declaration."""
    for name, value in options.items():
        if value:
            raise click.BadParameter(why, param_hint=name)
