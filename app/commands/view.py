"""``flexura view``: window on a running campaign, or on its results."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from app.commands.bad_input import bad_input
from app.commands.options import PATH, Existing
from app.commands.output import Output, output_options

if TYPE_CHECKING:
    from app.view.opening import Kind


EXAMPLES = """\b
Examples:
  flexura view plate
  flexura view plate-run --theme dark
  flexura view plate-run --screenshot pictures
  flexura view hammer-run --beside hammer-run-before
  flexura view hammer-run --beside plate-run
"""
PICTURES = {".png", ".jpg", ".jpeg", ".svg", ".pdf"}
"""Endings of what is meant as a file, where a folder is wanted."""


@click.command(name="view", epilog=EXAMPLES, short_help="Show a campaign, running or recorded.")
@click.argument("folder", type=Existing("name a campaign, or the run folder of flexura identify or update"))
@click.option(
    "--window", "kind", type=click.Choice(["live", "recorded"]), help="Which window (default: the one that fits)."
)
@click.option(
    "--beside",
    type=Existing("name the run folder of another modal test, or of flexura update"),
    help="Run whose modes are compared: of another test, or of flexura update, for the MAC of test and twin.",
)
@click.option("--theme", type=click.Choice(["dark", "light"]), help="Default: the desktop's.")
@click.option(
    "--screenshot",
    type=PATH,
    metavar="DIR",
    help="Write every page as PNG into DIR and end; needs no screen.",
)
@output_options("the pictures written with --screenshot")
@bad_input
def command(
    folder: Path,
    kind: "Kind | None",
    beside: Path | None,
    theme: str | None,
    screenshot: Path | None,
    output: Output,
) -> None:
    """Look at FOLDER, a campaign or a run folder of a campaign or a modal test.

    A campaign that flexura acquire is writing is shown live: oven and plate against the programme, the last
    repeat's signals, spectrum and levels, FRFs as they come, the log. The window only reads the folder; closing
    it, or losing it, does nothing to the campaign, which it can pause or stop safely. The title says how many
    sweeps are there of how many.

    All else is shown as recorded, a page for every stage whose result is there: FRFs over temperature with
    linked cursors, modes followed over temperature, laws, the modes of test and twin with their MAC, the gap
    with the signatures of its candidates, focusing, moving fields. Of a modal test: FRFs (decibels, parts,
    Nyquist plane, others behind them; whether drive points and reciprocity hold) and modes (table,
    stabilization, moving shapes, AutoMAC), which can be dropped and added by hand; with --beside, the MAC of
    both runs' modes and what has changed, or the MAC of test and twin. Every plot exports PNG, SVG and CSV; F1
    shows the keys.
    """
    import os

    from app.view.folder import viewed

    found = viewed(folder)
    if screenshot is not None:
        from app.files.disk_room import RESULTS, require_room
        from app.files.results.run_folder import writable_folder

        if screenshot.suffix.lower() in PICTURES:
            raise click.BadParameter(
                f"{screenshot}: a folder is wanted, into which a picture of each page goes",
                param_hint="--screenshot",
            )
        writable_folder(screenshot, "--screenshot")
        require_room(screenshot, RESULTS, "--screenshot")
        os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    from app.view.application import application

    app = application()
    from app.terminal.end_signals import end_at_once
    from app.view.application import collected_here
    from app.view.opening import window_of
    from app.view.theme import THEMES, system_theme

    with collected_here():
        window = window_of(found, kind, THEMES[theme] if theme else system_theme(), beside)
        if screenshot is not None:
            from app.view.screenshots import screenshots

            with output.progress() as report:
                written = screenshots(window, screenshot, report)
            output.result(lambda: {"pictures": [str(picture.resolve()) for picture in written]})
            output.summary(f"{len(written)} pictures in {screenshot}")
            return
        window.show()
        end_at_once()
        app.exec()
