"""Options that several verbs share: one name, one wording, one range."""

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import click

Verb = TypeVar("Verb", bound=Callable[..., object])

PATH = click.Path(path_type=Path)

effects_of_twin = click.option("--twin", type=PATH, help="Twin file (of flexura gap) whose effects are on.")
laws_of_twin = click.option("--twin", type=PATH, help="Twin file (of flexura gap) whose laws to take.")
own_effects = click.option(
    "--effects",
    type=PATH,
    metavar="FOLDER",
    help="Effects of your own. Its *.py are run: name only folders you trust.",
)
which_rig = click.option(
    "--rig",
    type=click.Choice(["simulated", "real", "ni"]),
    help="Which rig (default: what EXPERIMENT says); ni is an older word for real.",
)
mains = click.option(
    "--mains",
    type=click.FloatRange(10.0, 400.0),
    default=50.0,
    show_default=True,
    help="Mains frequency, Hz, whose lines are left out.",
)


def out_folder(what: str) -> Callable[[Verb], Verb]:
    """Return --out FOLDER; `what` says which folder and what it is if none is named."""
    return click.option("--out", type=PATH, metavar="FOLDER", help=what)


picture = click.option("--picture", is_flag=True, help="Write a PNG file beside the result, too.")
run_out = out_folder("Run folder (default: NAME-run beside CAMPAIGN).")
