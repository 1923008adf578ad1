"""``flexura report``: all results of a run on one page."""

from pathlib import Path

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
    from app.files.results.run_folder import is_test_run, run_file, run_folder

    if not is_test_run(run):
        run_file(run, "frf.h5", "report")  # a wrong folder is reported before slow imports
    from app.report.written import write_report
    from app.terminal.engine import spare_workers

    with run_folder(run, out or run) as folder, output.progress() as report, spare_workers() as pool:
        made = write_report(run, folder, report, pictures=pictures, executor=pool)
    for sentence in made.amiss:
        output.note(sentence)
    output.result(made.record)
    output.summary(made.line())
