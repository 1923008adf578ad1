"""``flexura study``: the figures of the paper's section 5, and its Fig. 4, on a panel."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from app.commands.bad_input import bad_input
from app.commands.options import PANEL, RUN_WITH_LAWS, filter_options, out_folder
from app.commands.output import Output, output_options

if TYPE_CHECKING:
    from app.files.results.panel_files import Studies

FIGURES = ("4", "13", "14", "15", "16", "17", "18", "19")
"""As of `app.stages.study`, which takes too long to import for ``--help``."""
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
    from app.stages.study import StudyRequest, compute
    from app.summaries.numbers import led

    request = StudyRequest(figure=figure, run=run, panel=panel, as_paper=as_paper, seed=seed, changes=filters)
    with output.progress() as report:
        try:
            folder = out or request.folder
            found = compute(request, folder, report)
        except EvidenceCollapseError as error:
            output.failure(f"refused: {error}")
            raise click.exceptions.Exit(1) from error
        drawn = _draw(found.studies, figure, folder)

    from app.report.studies import rows

    numbers = rows(found.studies)
    output.result(
        lambda: [{"quantity": r.quantity, "paper": r.paper, "ours": r.ours} for r in numbers],
        lambda: show(numbers),
    )
    for note in found.notes:
        output.note(note)
    said = f"{drawn} figures, {len(numbers)} numbers; {found.seconds:.1f} s"
    output.summary(f"{led(found.extent)}{said}; {found.file}")


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
