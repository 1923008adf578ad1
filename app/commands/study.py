"""``flexura study``: the figures of the paper's section 5, and its Fig. 4, on a panel."""

import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from app.commands.bad_input import bad_input
from app.commands.options import PANEL, RUN_WITH_LAWS, filter_options, out_folder
from app.commands.output import Output, output_options

if TYPE_CHECKING:
    from analysis.compensation.settings import Training
    from app.files.studies_file import Studies

FIGURES = ("4", "13", "14", "15", "16", "17", "18", "19")
SPACINGS_OF = {"14": 5.0, "15": 5.0, "16": 5.0, "17": 5.0, "18": 5.0, "19": 8.0}
"""Widest spacing of training temperatures in figures with networks, °C."""

EXAMPLES = """\b
Examples:
  flexura study all plate-run
  flexura study 18 plate-run --as-paper
  flexura study 4 plate-run --panel door.toml --out door-run
"""


@click.command(name="study", epilog=EXAMPLES, short_help="Make the paper's figures on focusing.")
@click.argument("figure", type=click.Choice((*FIGURES, "all")))
@click.argument("run", type=RUN_WITH_LAWS, required=False)
@click.option("--panel", type=PANEL, help="Panel file (default: that of RUN's filters.h5).")
@click.option(
    "--as-paper", is_flag=True, help="Feed, scale, start, split and design as in the paper, all at once."
)
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="Of all that is random.")
@filter_options
@out_folder("Folder for studies.h5 and the figures (default: beside the laws).")
@output_options("our numbers beside the paper's")
@bad_input
def command(
    figure: str,
    run: Path | None,
    panel: Path | None,
    as_paper: bool,
    seed: int,
    filters: dict[str, Any],
    out: Path | None,
    output: Output,
) -> None:
    """Make FIGURE of the paper, or all, for a panel whose plate obeys the laws of RUN.

    4: STIF, time reversal, modal control and no control with taps, and a sweep in the time domain. 13: one filter
    for all temperatures. 14 to 17: the networks, their errors, their filters over temperature, the contrast they
    recover. 18: 6 to 16 nodes. 19: 14 nodes, trained every 2, 5 and 8 °C. Writes studies.h5 and a PNG file for
    each figure; `flexura report` shows them. Exit status 1 where the networks are refused.
    """
    from analysis.compensation.evidence_collapse import EvidenceCollapseError
    from analysis.compensation.settings import Training
    from app.files.campaign_inputs import extent_settings
    from app.files.provenance import provenance, sha256
    from app.files.run_folder import run_folder
    from app.stages.panel_inputs import panel_for
    from app.stages.panel_laws import laws_for, range_of
    from app.summaries.campaign_extent import led

    if as_paper and filters["design"] is not None:
        raise click.UsageError("--as-paper sets --design itself: leave one of them out")
    started = time.perf_counter()
    origin = laws_for(run, None, "study")
    laws_path, beside = origin.path, origin.folder
    declared, panel_path = panel_for(panel, beside, filters | ({"design": "inverse-fft"} if as_paper else {}))
    declared, notes = origin.on(declared)
    laws = declared.plate.grown(origin.laws)
    low, high = range_of(declared, laws, laws_path, origin.extent)
    training = Training(seed=seed)
    wanted = FIGURES if figure == "all" else (figure,)
    _check_spacing(wanted, training, (low, high), laws_path)

    from app.files.studies_file import save_studies
    from app.report.studies import rows
    from app.stages.study import run_studies
    from app.twins.panel_twin import panel_twin

    with run_folder(beside, out or beside) as folder, output.progress() as report:
        model = panel_twin(declared, laws, report)
        try:
            found = run_studies(
                wanted, model, declared, laws, training.as_paper() if as_paper else training, report
            )
        except EvidenceCollapseError as error:
            output.failure(f"refused: {error}")
            raise click.exceptions.Exit(1) from error
        inputs = {laws_path.name: sha256(laws_path), panel_path.name: sha256(panel_path)}
        settings = {"figures": list(wanted), "as_paper": as_paper, "panel": declared.model_dump(mode="json")}
        settings |= extent_settings(origin.extent)
        save_studies(folder / "studies.h5", declared, found, provenance(inputs, settings, seed))
        drawn = _draw(found, figure, folder)
    numbers = rows(found)
    output.result(
        lambda: [{"quantity": r.quantity, "paper": r.paper, "ours": r.ours} for r in numbers],
        lambda: show(numbers),
    )
    for note in notes:
        output.note(note)
    said = f"{drawn} figures, {len(numbers)} numbers; {time.perf_counter() - started:.1f} s"
    output.summary(f"{led(origin.extent)}{said}; {folder / 'studies.h5'}")


def _check_spacing(wanted: Sequence[str], training: "Training", span: tuple[float, float], laws: Path) -> None:
    """Raise ResultFileError if the laws' range is too narrow for the networks of a requested figure."""
    from analysis.focusing.temperatures import spaced
    from app.files.bad_file import ResultFileError

    spacing = max((SPACINGS_OF[one] for one in wanted if one in SPACINGS_OF), default=None)
    if spacing is None:
        return
    low, high = span
    try:
        training.check_temperatures(len(spaced(low, high, spacing)))
    except ValueError as error:
        raise ResultFileError(
            f"{laws}: {low:g} to {high:g} °C give too few temperatures {spacing:g} °C apart to train "
            "networks on; take laws of a wider range, or figures 4 and 13"
        ) from error


def _draw(found: "Studies", figure: str, folder: Path) -> int:
    """Write a PNG file for each requested figure; return their number."""
    from app.files.atomic import atomic_path
    from app.report.studies import pictures
    from app.report.style import drawing

    with drawing():
        drawn = [one for one in pictures(found) if figure == "all" or one.name == f"study-{figure}"]
        for picture in drawn:
            with atomic_path(folder / f"{picture.name}.png") as path:
                picture.figure.savefig(path, format="png", dpi=100, metadata={"Software": None})
    return len(drawn)


def show(numbers: list[Any]) -> None:
    """Print a table of our numbers and the paper's."""
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.table import Table

    table = Table(title="This panel beside the paper", header_style="bold", box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for heading in ("quantity", "paper", "this run"):
        table.add_column(heading)
    for row in numbers:
        table.add_row(row.quantity, row.paper, row.ours)
    Console().print(table)
