"""``flexura radiation``: what a listener hears of a panel, over temperature."""

import time
from pathlib import Path
from typing import TYPE_CHECKING

import click

from app.commands.bad_input import bad_input
from app.commands.options import PANEL, RUN_WITH_FILTERS, TRANSFERS, laws_of_twin, out_folder, picture
from app.commands.output import Output, output_options

if TYPE_CHECKING:
    from analysis.focusing.panel import Panel

EXAMPLES = """\b
Examples:
  flexura radiation plate-run
  flexura radiation plate-run --panel with-listeners.toml --picture
  flexura radiation scan-run --transfers scan.h5
"""


@click.command(name="radiation", epilog=EXAMPLES, short_help="Compute what a listener hears of a panel.")
@click.argument("run", type=RUN_WITH_FILTERS, required=False)
@click.option("--panel", type=PANEL, help="Panel file whose [sound] is taken (default: the filters' own).")
@click.option(
    "--transfers",
    type=TRANSFERS,
    help="Measured transfers, from which RUN's filters were made, in place of laws and a twin.",
)
@picture
@laws_of_twin
@out_folder("Folder for radiation.h5 (default: RUN).")
@output_options("levels, powers and directivity at every temperature")
@bad_input
def command(
    run: Path | None,
    panel: Path | None,
    transfers: Path | None,
    picture: bool,
    twin: Path | None,
    out: Path | None,
    output: Output,
) -> None:
    """Compute the sound of the panel of RUN with its filters, at the listeners that its file declares.

    RUN is a run folder with filters.h5 and laws (default: the current folder). The panel is mounted in a rigid
    baffle (Rayleigh's integral) or is the front of a closed box ([sound] mounting). Sound pressure in third-octave
    bands and its ripple, the worst line, group delay, radiated power and the target's share of it, radiation
    efficiency, directivity, level at rated drive, and contrast between zones, with the filters of each temperature
    and with those of 20 °C everywhere. From measured transfers also the errors that their noise makes. Writes
    radiation.h5.
    """
    if transfers is not None and twin is not None:
        raise click.UsageError("--transfers takes the place of laws and of --twin: leave one of them out")
    started = time.perf_counter()

    from app.files.filter_files import load_focusing
    from app.files.provenance import sha256
    from app.files.run_folder import run_file, run_folder
    from app.stages.panel_inputs import measured_panel
    from app.stages.panel_laws import laws_for
    from app.summaries.campaign_extent import extent_record, led

    given = run or Path()
    filters = given if given.is_file() else run_file(given, "filters.h5", "radiation")
    declared, focusing, _ = load_focusing(filters)
    inputs = {filters.name: sha256(filters)}
    if panel is not None:
        declared, inputs[panel.name] = with_sound(declared, panel), sha256(panel)
    origin = None if transfers is not None else laws_for(given, twin, "radiation")
    measured = None if transfers is None else measured_panel(declared, transfers, ())
    if origin is not None:
        inputs[origin.path.name] = sha256(origin.path)
    if transfers is not None:
        from app.files.transfers_file import transfer_files

        inputs |= {path.name: sha256(path) for path in transfer_files(transfers)}
    extent = None if origin is None else origin.extent

    from app.stages import radiation
    from app.summaries.radiation import notes, record, summary, table
    from app.terminal.tables import show

    beside = given.parent if given.is_file() else given
    with run_folder(beside, out or beside) as folder, output.progress() as report:
        reference = focusing.reference_temperature
        if origin is not None:
            found = radiation.compute(declared, origin.laws, focusing.bank, reference, report)
        elif measured is not None:
            found = radiation.compute_measured(measured, focusing.bank, reference, report)
        target = radiation.save(folder, declared, found, inputs, extent)
    if picture:
        from app.report.radiation import levels
        from app.report.style import saved

        saved(target.with_suffix(".png"), lambda: levels(found))
    seconds = time.perf_counter() - started
    output.result(
        lambda: record(declared, found, seconds) | extent_record(extent), lambda: show([table(declared, found)])
    )
    for note in (*(() if origin is None else origin.notes), *notes(declared, found)):
        output.note(note)
    output.summary(f"{led(extent)}{summary(declared, found, target, seconds)}")


def with_sound(panel: "Panel", path: Path) -> "Panel":
    """Return a panel with the listeners, air and mounting of another panel's file.

    Raises
    ------
    ResultFileError
        Where the file cannot be read, or lacks listeners of the zone that the filters play to.
    """
    import json

    from app.files.panel_file import panel_of_text, read_panel

    sound = read_panel(path).sound.model_dump(mode="json")
    return panel_of_text(json.dumps(panel.model_dump(mode="json") | {"sound": sound}), str(path))
