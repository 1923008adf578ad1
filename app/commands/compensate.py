"""``flexura compensate``: temperature-dependent filters by networks and other methods."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from app.commands.bad_input import bad_input
from app.commands.options import FOCUSING_METHODS, PANEL, RUN, TRANSFERS, filter_options, laws_of_twin, out_folder
from app.commands.output import Output, output_options
from app.commands.training_options import training_of, training_options, typed

if TYPE_CHECKING:
    from analysis.campaign_extent import CampaignExtent
    from analysis.compensation.settings import Training
    from analysis.progress import Progress
    from app.stages.compensate import CompensatedPanel

GOOD_LOSS = 0.02
"""Largest loss of contrast of networks against directly computed filters, at any line and temperature."""

ROOM = 20e6
"""Bytes of ``compensation.h5``, roughly: with two actuators it is 11 MB."""

EXAMPLES = """\b
Examples:
  flexura compensate plate-run
  flexura compensate plate-run --spacing 4 --restarts 3
  flexura compensate plate-run --place 8
  flexura compensate plate-run --across 10 --across 20
  flexura compensate --transfers scan.h5 --panel scanned.toml --out scan-run
  flexura compensate plate-run --feed temperature --start random --split matlab --seed 7
"""


@click.command(
    name="compensate", epilog=EXAMPLES, short_help="Train networks that give filters at any temperature."
)
@click.argument("run", type=RUN, required=False)
@click.option("--panel", type=PANEL, help="Panel file (default: that of RUN's filters.h5).")
@click.option(
    "--spacing",
    type=click.FloatRange(0.5, 30.0),
    default=5.0,
    show_default=True,
    help="°C between training temperatures.",
)
@click.option(
    "--place",
    type=click.IntRange(4, 40),
    help="Place so many training temperatures where the filters need them, instead of every SPACING.",
)
@click.option(
    "--across",
    type=click.FloatRange(0.1, 60.0),
    multiple=True,
    help="Loss of contrast for this difference between two sides of the panel, K; repeat for more.",
)
@click.option(
    "--transfers",
    type=TRANSFERS,
    help="Measured transfers at five temperatures or more (HDF5, a folder of UFF58), in place of laws and twin.",
)
@training_options
@click.option(
    "--device", default="cpu", show_default=True, help="Where networks are trained: cpu, cuda, cuda:1, ..."
)
@click.option(
    "--method",
    type=click.Choice(FOCUSING_METHODS),
    help="How the filters are designed that are followed (default: as in RUN's filters.h5, else stif).",
)
@click.option(
    "--as-paper", is_flag=True, help="Feed, scale, start, split and design as in the paper, all at once."
)
@filter_options
@laws_of_twin
@out_folder("Folder for compensation.h5 (default: beside the laws).")
@output_options("the figures of every method")
@bad_input
def command(
    run: Path | None,
    panel: Path | None,
    spacing: float,
    place: int | None,
    across: tuple[float, ...],
    transfers: Path | None,
    training: dict[str, Any],
    device: str,
    method: str | None,
    as_paper: bool,
    filters: dict[str, Any],
    twin: Path | None,
    out: Path | None,
    output: Output,
) -> None:
    """Train one network per actuator: temperature in, the taps of its filter out.

    RUN is a run folder with laws.h5, or a laws file (default: the current folder). Of a folder, those of its
    best twin are used: corrected, if flexura gap named an effect there. Trains on the filters every
    SPACING °C, designed as in RUN's filters.h5 unless said otherwise, and judges networks, linear interpolation,
    cubic splines, interpolation at equal reduced frequency and principal filters against the filters computed
    every 0.25 °C. The uncertainty of the contrast due to that of the laws is given as a band. With --transfers,
    trains on the filters of all measured temperatures, and tests each inner one with networks trained without it.
    Writes compensation.h5. Exit status 1 where a network is refused, or loses more than 0.02 of contrast at any
    line of any temperature tested.
    """
    from analysis.compensation.evidence_collapse import EvidenceCollapseError

    started = time.perf_counter()
    filters = filters | ({"design": "inverse-fft"} if as_paper else {})
    chosen = training_of(training, as_paper)
    if transfers is None:
        task = _from_laws(run, twin, panel, filters, method, (spacing, place, across), chosen)
    else:
        _refuse_with_transfers(twin, place, across)
        task = _from_transfers(run, transfers, panel, filters, method)
    if task.nodes is not None and not typed("nodes"):
        chosen = replace(chosen, nodes=task.nodes)

    from app.files.provenance import sha256
    from app.files.run_folder import run_folder
    from app.stages import compensate
    from app.stages.panel_inputs import checked_device
    from app.terminal.campaign_extent import extent_record, led
    from app.terminal.compensation import notes, record, show, summary

    checked_device(device)
    with run_folder(task.beside, out or task.beside, ROOM) as folder, output.progress() as report:
        try:
            computed = task.compute(report, training=chosen, device=device)
        except EvidenceCollapseError as error:
            output.failure(f"refused: {error}")
            raise click.exceptions.Exit(1) from error
        target = compensate.save(folder, computed, {path.name: sha256(path) for path in task.inputs}, task.extent)
    found = computed.compensation
    seconds = time.perf_counter() - started
    output.result(lambda: record(found, seconds) | extent_record(task.extent), lambda: show(found))
    for note in [*task.notes, *notes(found, chosen)]:
        output.note(note)
    output.summary(f"{led(task.extent)}{summary(found, target, seconds)}")
    if found.largest_loss[0] > GOOD_LOSS:
        raise click.exceptions.Exit(1)


@dataclass(frozen=True)
class _CompensateTask:
    """Task: computation, input files, and hidden nodes for few temperatures; None for many.

    And the extent of an incomplete campaign whose laws are used.
    """

    compute: Callable[..., "CompensatedPanel"]
    inputs: tuple[Path, ...]
    beside: Path
    notes: list[str]
    nodes: int | None
    extent: "CampaignExtent | None" = None


def _refuse_with_transfers(twin: Path | None, place: int | None, across: tuple[float, ...]) -> None:
    """Refuse options on temperatures or laws together with measured transfers."""
    if twin is not None or place is not None or across or typed("spacing"):
        raise click.UsageError(
            "--transfers takes the place of --twin, and trains on the temperatures measured: leave out "
            "--spacing, --place and --across"
        )


def _from_laws(
    run: Path | None,
    twin: Path | None,
    panel: Path | None,
    filters: dict[str, Any],
    method: str | None,
    wanted: tuple[float, int | None, tuple[float, ...]],
    training: "Training",
) -> _CompensateTask:
    """Prepare the compensation of a panel from material laws."""
    from analysis.compensation.settings import suited_nodes
    from app.stages.panel_inputs import method_for, panel_for
    from app.stages.panel_laws import laws_for, range_of, said_of_range

    spacing, place, across = wanted
    if place is not None and typed("spacing"):
        raise click.UsageError("--place and --spacing each choose the training temperatures: name one of them")
    found = laws_for(run, twin, "compensate")
    declared, panel_path = panel_for(panel, found.folder, filters)
    followed = method_for(method, panel, found.folder)  # type: ignore[arg-type]
    low, high = range_of(declared, found.laws, found.path, found.extent)
    _check_temperatures(wanted, training, (low, high), found.extent)
    declared, notes = found.on(declared)
    notes += said_of_range(declared, (low, high))

    from app.stages import compensate

    compute = partial(
        compensate.compute, declared, found.laws, spacing=spacing, place=place, across=across, method=followed
    )
    nodes = None if place is None else suited_nodes(place)
    return _CompensateTask(compute, (found.path, panel_path), found.folder, notes, nodes, found.extent)


def _check_temperatures(
    wanted: tuple[float, int | None, tuple[float, ...]],
    training: "Training",
    span: tuple[float, float],
    extent: "CampaignExtent | None",
) -> None:
    """Refuse --spacing, --place or --across that the laws' range of temperatures does not allow."""
    from analysis.compensation.knots import check_places
    from analysis.focusing.temperatures import spaced

    (spacing, place, across), (low, high) = wanted, span
    of_part = "" if extent is None else f" (the campaign of the laws is not complete: {extent.said})"
    try:
        if place is None:
            training.check_temperatures(len(spaced(low, high, spacing)))
        else:
            check_places(place, low, high)
    except ValueError as error:
        option = f"--spacing {spacing:g}, {low:g} to {high:g} °C" if place is None else "--place"
        raise click.UsageError(f"{option}: {error}{of_part}") from error
    if across and max(across) > high - low:
        raise click.UsageError(
            f"--across {max(across):g} K: the laws hold from {low:g} to {high:g} °C, so that up to "
            f"{high - low:g} K can be judged{of_part}"
        )


def _from_transfers(
    run: Path | None, transfers: Path, panel: Path | None, filters: dict[str, Any], method: str | None
) -> _CompensateTask:
    """Prepare the compensation of a panel from transfers measured at several temperatures."""
    from analysis.compensation.settings import FEWEST, suited_nodes
    from app.files.bad_file import ResultFileError
    from app.files.transfers_file import transfer_files
    from app.stages.panel_inputs import measured_panel, method_for, scanned_panel

    beside = run or transfers.parent
    declared, panel_path = scanned_panel(panel, beside, filters)
    followed = method_for(method, panel, beside)  # type: ignore[arg-type]
    if followed == "modal-control":
        raise click.UsageError("--method modal-control needs the modes of a model; --transfers has none")
    measured = measured_panel(declared, transfers, ())
    count = len(measured.transfers.temperature)
    if count <= FEWEST:
        raise ResultFileError(
            f"{transfers}: transfers at {count} temperatures; at least {FEWEST + 1} are needed, to train on "
            "all but one: measure more, in one HDF5 file or a folder of universal files, one a temperature"
        )

    from app.stages import compensate

    def compute(report: "Progress", **choices: Any) -> "CompensatedPanel":
        return compensate.compute_measured(measured, report, method=followed, **choices)

    files = (*transfer_files(transfers), panel_path)
    return _CompensateTask(compute, files, beside, [], suited_nodes(count, measured=True))
