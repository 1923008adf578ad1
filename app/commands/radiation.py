"""``flexura radiation``: what a listener hears of a panel, over temperature."""

from pathlib import Path

import click

from app.commands.bad_input import bad_input
from app.commands.options import PANEL, RUN_WITH_FILTERS, TRANSFERS, laws_of_twin, out_folder, picture
from app.commands.output import Output, output_options

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
    from app.stages.radiation import RadiationRequest, compute

    request = RadiationRequest(run=run or Path(), panel=panel, transfers=transfers, twin=twin)
    with output.progress() as report:
        found = compute(request, out or request.filters.parent, report)

    from app.summaries.radiation import table
    from app.terminal.tables import show

    if picture and found.file is not None:
        from app.report.radiation import levels
        from app.report.style import saved

        saved(found.file.with_suffix(".png"), lambda: levels(found.radiation))
    output.result(found.record, lambda: show([table(found.panel, found.radiation)]))
    for note in found.notes:
        output.note(note)
    output.summary(repr(found))
