"""``flexura report``: everything a run found, on one page."""

from pathlib import Path

import click

from app.commands.bad_input import bad_input


@click.command(name="report")
@click.argument("run", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), help="Folder for report.html (default: RUN itself).")
@click.option("--pictures", is_flag=True, help="Write every figure as a PNG file beside the report, too.")
@bad_input
def command(run: Path, out: Path | None, pictures: bool) -> None:
    """Write one self-contained HTML page with every figure of RUN and the paper's figures beside ours.

    RUN is the folder the other verbs wrote into; a stage that has not been run is named with its command.
    """
    from app.files.atomic import atomic_path, write_text
    from app.progress import progress
    from app.report.page import Picture, page
    from app.report.sections import sections
    from app.report.style import drawing

    with progress() as report, drawing():
        found = sections(run, report)
        folder = out or run
        write_text(folder / "report.html", page(f"Flexura: {found.title}", found.subtitle, found.sections))
        if pictures:
            drawn = [item for section in found.sections for item in section.items if isinstance(item, Picture)]
            for picture in drawn:
                with atomic_path(folder / f"{picture.name}.png") as path:
                    picture.figure.savefig(path, format="png", dpi=100, metadata={"Software": None})
    click.echo(f"report: {(folder / 'report.html').resolve()}", err=True)
