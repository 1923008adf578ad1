"""``flexura examples``: the examples that come with Flexura, copied to where one works."""

import difflib
import shutil
from pathlib import Path

import click

from app.commands.bad_input import bad_input
from app.commands.options import out_folder
from app.commands.output import Output, output_options

EXAMPLES = """\b
Examples:
  flexura examples
  flexura examples pp-plate
  flexura examples simulated-rig.toml --out rigs
  flexura examples --all
"""


@click.command(name="examples", epilog=EXAMPLES, short_help="Copy examples to the current folder.")
@click.argument("name", required=False)
@click.option("--all", "everything", is_flag=True, help="All of them, into the folder examples.")
@out_folder("Folder that they are copied into (default: the current one).")
@output_options("what there is, or what was copied")
@bad_input
def command(name: str | None, everything: bool, out: Path | None, output: Output) -> None:
    """Copy the example NAME, a file or a folder, to the current folder; without NAME, list them.

    Commands of the guide and of --help name examples as examples/NAME: with --all they can be typed as they stand.
    Nothing that is there is overwritten.
    """
    from app.files.shipped import described, shipped, shipped_names

    if name is not None and everything:
        raise click.UsageError("NAME or --all, not both")
    if name is None and not everything:
        rows = [{"name": one, "about": described(one)} for one in shipped_names()]
        output.result(lambda: rows, lambda: _show(rows))
        return
    folder = out or Path()
    if everything:
        source, target = shipped(""), folder / "examples"
    else:
        found = (name or "").removeprefix("examples/").rstrip("/")
        there = shipped_names()
        found = found if found in there else next((one for one in there if Path(one).stem == found), found)
        if found not in there:
            close = difflib.get_close_matches(found, there, 1)
            meant = f"did you mean {close[0]}? " if close else ""
            raise click.ClickException(f"no example {name!r}; {meant}there are: {', '.join(there) or 'none here'}")
        source, target = shipped(found), folder / found
    if target.exists():
        raise click.ClickException(f"{target}: is there already; name another folder with --out, or remove it")
    from app.files.results.run_folder import writable_folder

    writable_folder(folder, "--out")
    if source.is_dir():
        shutil.copytree(source, target, ignore=shutil.ignore_patterns("__pycache__"))
    else:
        shutil.copyfile(source, target)
    output.result(lambda: {"copied": str(target)})
    output.summary(f"{target}: copied")


def _show(rows: list[dict[str, str]]) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, show_header=False)
    for row in rows:
        table.add_row(row["name"], row["about"])
    Console().print(table)
