"""Bad input ends a verb with one message on stderr and exit status 2, never with a traceback."""

import functools
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import ParamSpec, TypeVar

import click

from app.files.bad_file import Misplaced, ResultFileError, UnsuitedOptionError
from app.files.campaign_error import CampaignFileError
from app.files.disk_room import told

Words = ParamSpec("Words")
Result = TypeVar("Result")


def fault_picture(wrong: Misplaced, options: Mapping[str, object]) -> str:
    """Draw the error, and return a sentence with the picture's path, beside --out or else the declaration."""
    from app.files.atomic import atomic_path
    from app.report.declared import picture, pieces_declared

    target = _target(wrong.source, options.get("out"))
    figure = picture(pieces_declared(wrong), wrong.places)
    try:
        with atomic_path(target) as path:
            figure.savefig(path, format="png", dpi=120)
    except OSError as error:
        return f"(a picture of it is missing: {error})"
    return f"picture: {target}"


def _require_finite(options: Mapping[str, object]) -> None:
    """Refuse nan and inf: Python reads them as numbers, and no range of click's keeps nan out."""
    for name, value in options.items():
        if isinstance(value, Mapping):  # options that several verbs share are handed on as one
            _require_finite(value)
        for number in value if isinstance(value, tuple | list) else (value,):
            if isinstance(number, float) and not math.isfinite(number):
                context = click.get_current_context(silent=True)
                known = [] if context is None else context.command.params
                option = next((one.opts[0] for one in known if one.name == name), f"--{name.replace('_', '-')}")
                raise click.BadParameter(f"{number}; allowed: a finite number", param_hint=f"'{option}'")


def _target(source: Path, out: object) -> Path:
    from app.files.campaigns.kind import DECLARATION

    beside = source.parent if source.name == DECLARATION else source.with_suffix("")
    return (out if isinstance(out, Path) else beside).resolve().with_name(f"{beside.resolve().name}-geometry.png")


def bad_input(verb: Callable[Words, Result]) -> Callable[Words, Result]:
    """Convert errors of ``app.files`` to click's; place it between ``@click.command`` and the function.

    So is the refusal of a disk: one that is full, read-only or fails. What was finished before is there.

    For a declaration with a geometric error, a picture of it is written, and its path is in the message.

    Other errors are not converted: a ValueError from the computation is a defect and needs its traceback.
    """

    @functools.wraps(verb)
    def checked(*args: Words.args, **options: Words.kwargs) -> Result:
        _require_finite(options)
        try:
            return verb(*args, **options)
        except UnsuitedOptionError as error:  # what was typed is wrong, not a file
            raise click.UsageError(str(error)) from error
        except (CampaignFileError, ResultFileError) as error:
            message = str(error)
            if error.misplaced is not None:
                message += "\n" + fault_picture(error.misplaced, options)
            raise click.ClickException(message) from error
        except OSError as error:
            message = told(error) or ""
            if not message:
                raise
            raise click.ClickException(message) from error

    return checked
