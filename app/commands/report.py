"""``flexura report``: all results of a run on one page."""

from pathlib import Path
from typing import Any

import click

from app.commands.bad_input import bad_input
from app.commands.options import Existing, out_folder
from app.commands.output import Output, output_options

EXAMPLES = """\b
Examples:
  flexura report plate-run
  flexura report plate-run --pictures --out for-the-paper
"""


@click.command(name="report", epilog=EXAMPLES, short_help="Write everything that was found on one page.")
@click.argument("run", type=Existing("make it with: flexura identify or flexura update"))
@click.option("--pictures", is_flag=True, help="Write every figure as a PNG file beside the report, too.")
@out_folder("Folder for report.html (default: RUN itself).")
@output_options("path and contents of the page")
@bad_input
def command(run: Path, pictures: bool, out: Path | None, output: Output) -> None:
    """Write one self-contained HTML page with every figure of RUN and the paper's figures beside ours.

    It begins with the result in words: what the plate is made of, what its twin lacks, what to do next. E, nu and
    eta are those of the best twin: corrected, if flexura gap named an effect, the uncorrected ones beside them.
    RUN is the folder the other verbs wrote into; a stage that has not been run is named with its command.
    """
    from app.files.atomic import atomic_path, write_text
    from app.files.run_folder import is_test_run, run_file, run_folder

    if not is_test_run(run):
        run_file(run, "frf.h5", "report")  # a wrong folder is reported before slow imports
    from app.report.page import Absent, Picture, page
    from app.report.sections import sections
    from app.report.style import drawing

    with run_folder(run, out or run) as folder, output.progress() as report, drawing():
        found = sections(run, report)
        html = page(f"Flexura: {found.title}", found.subtitle, found.sections, found.lead)
        write_text(folder / "report.html", html)
        drawn = [item for section in found.sections for item in section.items if isinstance(item, Picture)]
        if pictures:
            for picture in drawn:
                with atomic_path(folder / f"{picture.name}.png") as path:
                    picture.figure.savefig(path, format="png", dpi=100, metadata={"Software": None})
    target = (folder / "report.html").resolve()
    size = target.stat().st_size
    missing = [s.title for s in found.sections if any(isinstance(item, Absent) for item in s.items)]

    def record() -> dict[str, Any]:
        return {
            "report": str(target),
            "bytes": size,
            "sections": [section.title for section in found.sections],
            "not_run_yet": missing,
            "amiss": list(found.amiss),
            "figures": [picture.name for picture in drawn],
        }

    for sentence in found.amiss:
        output.note(sentence)
    output.result(record)
    absent = f", not run yet: {', '.join(missing)}" if missing else ""
    output.summary(f"report of {len(drawn)} figures, {size / 1e6:.1f} MB{absent}: {target}")
