"""``flexura focus``: filters that move the target of a panel alone, over temperature."""

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from app.commands.bad_input import bad_input
from app.commands.options import (
    FOCUSING_METHODS,
    PANEL,
    RUN_WITH_LAWS,
    TRANSFERS,
    filter_options,
    laws_of_twin,
    out_folder,
)
from app.commands.output import Output, output_options

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


EXAMPLES = """\b
Examples:
  flexura focus plate-run
  flexura focus plate-run --panel door.toml --temperature 20 --temperature 45
  flexura focus plate-run --taps 128 --outside-weight 10
  flexura focus plate-run --design inverse-fft
  flexura focus plate-run/laws.h5
  flexura focus --twin other-run/twin.toml
  flexura focus --transfers scan.uff --panel scanned.toml --temperature 21.5 --out scan-run
"""


@click.command(name="focus", epilog=EXAMPLES, short_help="Design focusing filters over temperature.")
@click.argument("run", type=RUN_WITH_LAWS, required=False)
@click.option("--panel", type=PANEL, help="Panel file (default: the paper's section 2).")
@click.option(
    "--temperature", "temperatures", type=float, multiple=True, help="°C; repeat for more (default: every 5 °C)."
)
@click.option(
    "--method",
    type=click.Choice(FOCUSING_METHODS),
    default="stif",
    show_default=True,
    help="How filters are designed.",
)
@click.option("--regularisation", type=click.Choice(("tikhonov", "truncation")), help="Default: the panel's.")
@click.option(
    "--tolerance", type=float, help="Share of the largest singular value, 1e-6 to 0.9 (default: the panel's)."
)
@filter_options
@click.option(
    "--transfers",
    type=TRANSFERS,
    help="Measured transfers (UFF58 with nodes, a folder of such, or HDF5) in place of RUN's laws and a twin.",
)
@laws_of_twin
@out_folder("Folder for filters.h5 (default: beside the laws).")
@output_options("the figures")
@bad_input
def command(
    run: Path | None,
    panel: Path | None,
    temperatures: tuple[float, ...],
    method: str,
    regularisation: str | None,
    tolerance: float | None,
    filters: dict[str, Any],
    transfers: Path | None,
    twin: Path | None,
    out: Path | None,
    output: Output,
) -> None:
    """Design focusing filters for a panel whose plate obeys the laws of RUN.

    RUN is a run folder with laws.h5, or a laws file (default: the current folder). Of a folder, those of its
    best twin are used: corrected, if flexura gap named an effect there. A panel that is declared as the plate
    that was measured gets the thickness, mass and places found with them. Actuators, taps and target are
    declared in the panel's TOML file. The taps minimise the error of the field, with a higher weight outside the
    target. Performance is given as contrast (the energy over the target's share of the energy over the plate,
    eq. 9, mean and worst line), the same normalised by area, level and phase over the band, latency and peak
    drive, with the filters of each temperature and with those of 20 °C everywhere. Writes filters.h5.
    """
    if transfers is not None and (run is not None or twin is not None):
        raise click.UsageError("--transfers takes the place of RUN and of --twin; name results' folder by --out")
    started = time.perf_counter()

    from app.stages.panel.requests import FocusRequest

    changes = {"regularisation": regularisation, "tolerance": tolerance} | filters
    wanted = FocusRequest(run, twin, panel, changes, method, temperatures, transfers)  # type: ignore[arg-type]
    task = wanted.task()

    from app.files.results.panel_files import other_filters
    from app.files.results.run_folder import run_folder
    from app.stages import focus
    from app.summaries.focusing import correction, notes, record, summary, table, tradeoff
    from app.summaries.numbers import extent_record, led
    from app.terminal.tables import show

    with run_folder(task.beside, out or task.beside) as folder, output.progress() as report:
        found = task.compute(report)
        focusing, lost = found.focusing, found.uncorrected
        gone = replaced(folder / focus.FILTERS, focusing.temperature)
        target = focus.save(folder, found, task.hashes(), task.extent)
        gone += other_filters(folder)
        task.remember(folder)
    seconds = time.perf_counter() - started
    output.result(
        lambda: (
            record(found.panel, focusing, found.comparison, lost, seconds, found.pareto)
            | extent_record(task.extent)
        ),
        lambda: show([table(found.panel, focusing)]),
    )
    said = (*notes(found.panel, focusing), *tradeoff(found.panel, found.pareto))
    for note in (*said, *task.notes, *correction(focusing, lost), *gone):
        output.note(note)
    output.summary(f"{led(task.extent)}{summary(found.panel, focusing, target, seconds)}")


def replaced(target: Path, temperature: "NDArray[np.float64]") -> list[str]:
    """Return a note if the new filters, of `temperature` (T,), °C, replace filters of other temperatures."""
    from app.files.bad_file import ResultFileError
    from app.files.results.panel_files import load_focusing
    from app.summaries.focusing import temperatures_in_words

    if not target.is_file():
        return []
    try:
        before = load_focusing(target)[1].temperature
    except ResultFileError:  # unreadable, so no loss
        return []
    if before.tolist() == temperature.tolist():
        return []
    return [f"{target} held filters of {temperatures_in_words(before)}: replaced. To keep both, name --out FOLDER"]
