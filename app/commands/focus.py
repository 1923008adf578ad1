"""``flexura focus``: filters that move the target of a panel alone, over temperature."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
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

    from analysis.campaign_extent import CampaignExtent
    from analysis.progress import Progress
    from app.stages.focus import FocusedPanel

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
    changes = {"regularisation": regularisation, "tolerance": tolerance} | filters
    started = time.perf_counter()
    if transfers is None:
        task = _from_laws(run, twin, panel, changes, method, temperatures)
    elif run is not None or twin is not None:
        raise click.UsageError("--transfers takes the place of RUN and of --twin; name results' folder by --out")
    else:
        task = _from_transfers(transfers, panel, changes, method, temperatures)

    from app.files.provenance import sha256
    from app.files.run_folder import run_folder
    from app.stages import focus
    from app.terminal.campaign_extent import extent_record, led
    from app.terminal.focusing import correction, notes, record, show, summary

    with run_folder(task.beside, out or task.beside) as folder, output.progress() as report:
        found = task.compute(report)
        focusing, lost = found.focusing, found.uncorrected
        gone = replaced(folder / focus.FILTERS, focusing.temperature)
        target = focus.save(folder, found, {path.name: sha256(path) for path in task.inputs}, task.extent)
    seconds = time.perf_counter() - started
    output.result(
        lambda: record(found.panel, focusing, found.comparison, lost, seconds) | extent_record(task.extent),
        lambda: show(found.panel, focusing),
    )
    for note in (*notes(found.panel, focusing), *task.notes, *correction(focusing, lost), *gone):
        output.note(note)
    output.summary(f"{led(task.extent)}{summary(focusing, target, seconds)}")


@dataclass(frozen=True)
class _FocusTask:
    """Task: computation, input files, and the extent of an incomplete campaign whose laws are used."""

    compute: Callable[["Progress"], "FocusedPanel"]
    inputs: tuple[Path, ...]
    beside: Path
    notes: list[str]
    extent: "CampaignExtent | None" = None


def _from_laws(
    run: Path | None,
    twin: Path | None,
    panel: Path | None,
    changes: dict[str, Any],
    method: str,
    temperatures: tuple[float, ...],
) -> _FocusTask:
    """Prepare filters for a panel from material laws."""
    import numpy as np

    from app.stages.panel_inputs import panel_of
    from app.stages.panel_laws import laws_for, range_of, said_of_range, within

    declared, panel_path = panel_of(panel, changes)
    found = laws_for(run, twin, "focus")
    low, high = range_of(declared, found.laws, found.path, found.extent)
    named = within(np.array(sorted(set(temperatures))), found.laws, found.path) if temperatures else None
    declared, notes = found.on(declared)
    notes += said_of_range(declared, (low, high)) if named is None else []

    from app.stages import focus

    span = np.array([low, high]) if named is None else named
    compute = partial(
        focus.compute,
        declared,
        found.laws,
        temperature=named,
        method=method,  # type: ignore[arg-type]
        uncorrected=found.without_effects(span),
    )
    return _FocusTask(compute, (found.path, panel_path), found.folder, notes, found.extent)


def _from_transfers(
    transfers: Path, panel: Path | None, changes: dict[str, Any], method: str, temperatures: tuple[float, ...]
) -> _FocusTask:
    """Prepare filters for a panel from measured transfers."""
    from app.files.transfers_file import transfer_files
    from app.stages.panel_inputs import measured_panel, panel_of

    declared, panel_path = panel_of(panel, changes)
    if method == "modal-control":
        raise click.UsageError("--method modal-control needs the modes of a model; --transfers has none")
    measured = measured_panel(declared, transfers, temperatures)

    from app.stages import focus

    compute = partial(focus.compute_measured, measured, method=method)  # type: ignore[arg-type]
    return _FocusTask(compute, (*transfer_files(transfers), panel_path), transfers.parent, [])


def replaced(target: Path, temperature: "NDArray[np.float64]") -> list[str]:
    """Return a note if the new filters, of `temperature` (T,), °C, replace filters of other temperatures."""
    from app.files.bad_file import ResultFileError
    from app.files.filter_files import load_focusing
    from app.terminal.focusing import temperatures_in_words

    if not target.is_file():
        return []
    try:
        before = load_focusing(target)[1].temperature
    except ResultFileError:  # unreadable, so no loss
        return []
    if before.tolist() == temperature.tolist():
        return []
    return [f"{target} held filters of {temperatures_in_words(before)}: replaced. To keep both, name --out FOLDER"]
