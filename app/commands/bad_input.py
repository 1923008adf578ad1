"""Bad input ends a verb with one message on stderr and exit status 2, never with a traceback."""

import functools
from collections.abc import Callable
from typing import ParamSpec, TypeVar

import click

from app.commands.fault_picture import fault_picture
from app.files.bad_file import ResultFileError, UnsuitedOptionError
from app.files.campaign_error import CampaignFileError
from app.files.unwritten import told

Words = ParamSpec("Words")
Result = TypeVar("Result")


def bad_input(verb: Callable[Words, Result]) -> Callable[Words, Result]:
    """Convert errors of ``app.files`` to click's; place it between ``@click.command`` and the function.

    So is the refusal of a disk: one that is full, read-only or fails. What was finished before is there.

    For a declaration with a geometric error, a picture of it is written, and its path is in the message.

    Other errors are not converted: a ValueError from the computation is a defect and needs its traceback.
    """

    @functools.wraps(verb)
    def checked(*args: Words.args, **options: Words.kwargs) -> Result:
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
