"""Options common to several verbs, each with one name, text and range; campaigns that are watched."""

import difflib
import functools
import os
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar, cast

import click

from analysis.recordings.grid_frequency import MAINS_RANGE

Verb = TypeVar("Verb", bound=Callable[..., object])

PATH = click.Path(path_type=Path)
"""A file or folder that is written, or may be missing."""


def _mistyped(path: Path) -> str:
    """Name the file or folder beside `path` that is called almost alike."""
    with suppress(OSError, ValueError):
        there = [beside.name for beside in path.parent.iterdir()]
        close = difflib.get_close_matches(path.name, there, 1, MISTYPED)
        return f" (did you mean {path.parent / close[0]}?)" if close else ""
    return ""


def _shipped(path: Path) -> str:
    """Say how an example is got that comes with Flexura and is not in the current folder; else empty."""
    from app.files.shipped import shipped

    if path.parts[:1] != ("examples",) or ".." in path.parts or not shipped(str(Path(*path.parts[1:]))).exists():
        return ""
    return "it comes with Flexura: flexura examples --all copies all of them to the folder examples"


MISTYPED = 0.8
"""Likeness of names, 0 to 1, from which one is taken for the other mistyped."""


class Existing(click.Path):
    """A file or folder that is read: reported if missing, before slow imports.

    Parameters
    ----------
    onward : str
        What is allowed, or how to make it: the end of the message.
    """

    def __init__(self, onward: str) -> None:
        super().__init__(path_type=Path)
        self.onward = onward

    def convert(
        self, value: str | os.PathLike[str], param: click.Parameter | None, ctx: click.Context | None
    ) -> Path:
        """Return the path.

        Parameters
        ----------
        value : str or path
        param : click.Parameter or None
            The argument or option; an option is named in the message.
        ctx : click.Context or None
            Not used.

        Raises
        ------
        click.ClickException
            If it does not exist.
        """
        path = Path(os.fspath(value))
        if not os.path.exists(path):  # noqa: PTH110 (Path.exists raises for too long a name or without permission)
            option = f"{param.opts[0]} " if isinstance(param, click.Option) else ""
            raise click.ClickException(
                f"{option}{path}: does not exist; {_shipped(path) or self.onward}{_mistyped(path)}"
            )
        return path


CAMPAIGN = Existing(
    "allowed: a folder with campaign.toml (recorded), protocol.json (imported) or plate.toml (FRFs)"
)
EXPERIMENT = Existing("allowed: an experiment's file (*.toml); a campaign folder is made from it")
RUN_WITH_LAWS = Existing("make it with: flexura update")
RUN = Existing("make it with: flexura update, or flexura focus --transfers")
RUN_WITH_FILTERS = Existing("make it with: flexura focus")
PANEL = Existing("allowed: a panel's file (*.toml), such as examples/section2-panel.toml")
WEATHER = Existing("allowed: a weather's file (*.toml), such as examples/warming-car.toml")
SOUND = Existing("allowed: WAV, FLAC and what else libsndfile reads")
TRANSFERS = Existing("allowed: a universal file (UFF58), a folder of such, or HDF5")
TWIN = Existing("make it with: flexura gap")

effects_of_twin = click.option("--twin", type=TWIN, help="Twin file (of flexura gap) whose effects are on.")
laws_of_twin = click.option("--twin", type=TWIN, help="Twin file (of flexura gap) whose laws to take.")
own_effects = click.option(
    "--effects",
    type=Existing("allowed: a folder of *.py, an effect each"),
    metavar="FOLDER",
    help="Effects of your own. Its *.py are run: name only folders you trust.",
)
which_rig = click.option(
    "--rig",
    type=click.Choice(["simulated", "real", "ni"]),
    help="Which rig (default: that of EXPERIMENT); ni is an older name of real.",
)
mains = click.option(
    "--mains",
    type=click.FloatRange(*MAINS_RANGE),
    default=50.0,
    show_default=True,
    help="Mains frequency, Hz, whose lines are left out.",
)


def out_folder(what: str) -> Callable[[Verb], Verb]:
    """Return --out FOLDER; `what` says which folder and what it is if none is named."""
    return click.option("--out", type=PATH, metavar="FOLDER", help=what)


picture = click.option("--picture", is_flag=True, help="Write a PNG file beside the result, too.")
run_out = out_folder("Run folder (default: NAME-run beside CAMPAIGN).")

following_method = click.option(
    "--method",
    type=click.Choice(("network", "low-rank", "cubic-spline", "cubic-spline-rigidity", "linear")),
    help="How filters follow the temperature (default: what compensate recommends, else a spline).",
)


def engine_options(verb: Verb) -> Verb:
    """Add --workers and --cluster to a verb, which receives them as one `app.terminal.engine.Engine`."""

    @functools.wraps(verb)
    def engaged(*args: Any, workers: int | None, cluster: str | None, **options: Any) -> object:
        from app.terminal.engine import Engine

        if workers is not None and cluster is not None:
            raise click.UsageError("--workers are processes of this machine, --cluster those of others: name one")
        return verb(*args, engine=Engine(workers, cluster), **options)

    on_this = click.option(
        "--workers", type=click.IntRange(1, 256), help="Processes of this machine (default: 2)."
    )
    elsewhere = click.option(
        "--cluster",
        metavar="ADDRESS",
        help="Dask cluster that does the work instead: tcp://HOST:PORT of its scheduler, or its scheduler file.",
    )
    return cast(Verb, on_this(elsewhere(engaged)))


FOCUSING_METHODS = ("stif", "time-reversal", "modal-control", "none")
FILTER_OPTIONS = (
    click.option(
        "--aim",
        type=click.Choice(("field", "volume", "listeners")),
        help="What filters are chosen by: field, net volume or sound at listeners (default: the panel's).",
    ),
    click.option("--zone", help="Zone of listeners that is played to; the others are to be quiet (default: all)."),
    click.option(
        "--design",
        type=click.Choice(("field", "inverse-fft")),
        help="Least squares of the field, or a cut inverse FFT as in the paper (default: the panel's).",
    ),
    click.option("--taps", type=int, help="Length of a filter, 16 to 16384 (default: the panel's)."),
    click.option("--sample-rate", type=float, help="Hz that the filters run at (default: the panel's)."),
    click.option(
        "--delay", type=int, help="Modelling delay, samples (default: the panel's, else what suits the taps)."
    ),
    click.option(
        "--outside-weight",
        type=float,
        help="Weight of what moves outside, 1 to 10000 (default: the panel's, else 3; 1 for inverse-fft).",
    ),
    click.option(
        "--thermometer-error",
        type=float,
        help="°C either way that filters are robust to (default: the panel's, else 0).",
    ),
    click.option(
        "--level",
        type=float,
        help="dB of the displacement asked for, at every line (default: the panel's, else free).",
    ),
)


def filter_options(verb: Verb) -> Verb:
    """Add the options of the tap design to a verb, which receives them as one mapping, `filters`."""

    @functools.wraps(verb)
    def designing(*args: Any, **options: Any) -> object:
        kinds = ("aim", "zone", "design")
        numbers = ("taps", "sample_rate", "delay", "outside_weight", "thermometer_error", "level")
        given = {name: options.pop(name) for name in (*kinds, *numbers)}
        return verb(*args, filters=given, **options)

    for option in reversed(FILTER_OPTIONS):
        designing = option(designing)
    return cast("Verb", designing)


_NOTIFY = click.option(
    "--notify",
    multiple=True,
    metavar="ADDRESS",
    help="Tell an address of Apprise (mail, Teams, Slack, ntfy, MQTT, ...). $NAME in it: a variable of the "
    "environment; @FILE: addresses from a file of mode 600. Needs the extra notify.",
)
_COMMAND = click.option(
    "--notify-command",
    multiple=True,
    metavar="COMMAND",
    help="Tell a command: program and arguments, no shell; the message is on its standard input.",
)


def require_campaigns(folders: Sequence[Path], *, wait: bool = False) -> None:
    """Refuse folders that hold no campaign, before slow imports; with `wait`, they need not be there yet."""
    from app.files.bad_file import quoted
    from app.files.campaigns.kind import HAMMER_TEST, PROTOCOL, is_campaign_folder, is_hammer_folder

    for folder in folders:
        there = folder.exists()
        if not (is_campaign_folder(folder) or is_hammer_folder(folder)) and (there or not wait):
            held = "is no campaign of flexura acquire" if there else "does not exist"
            allowed = f"allowed: a folder with {PROTOCOL} or {HAMMER_TEST}, as flexura acquire makes it"
            inside = [one for one in _below(folder) if is_campaign_folder(one) or is_hammer_folder(one)]
            name = f". It holds such: {', '.join(map(quoted, inside[:SHOWN]))}" if inside else ""
            raise click.ClickException(f"{folder}: {held}; {allowed}{name}")


SHOWN = 5
"""Campaigns named where a folder of them was given."""


def _below(folder: Path) -> list[Path]:
    try:
        return sorted(folder.iterdir())
    except OSError:
        return []


def telling_options(verb: Verb) -> Verb:
    """Add --notify and --notify-command to a verb."""
    return _NOTIFY(_COMMAND(verb))
