"""Bad input ends a verb with one message on stderr and exit status 2, never with a traceback."""

import functools
from collections.abc import Callable
from typing import ParamSpec, TypeVar

import click

from app.commands.fault_picture import fault_picture
from app.files.bad_file import ResultFileError
from app.files.campaign_error import CampaignFileError

Words = ParamSpec("Words")
Result = TypeVar("Result")


def bad_input(verb: Callable[Words, Result]) -> Callable[Words, Result]:
    """Turn the refusals of ``app.files`` into click's; put it between ``@click.command`` and the function.

    Where a declaration's geometry is wrong, a picture of it is written, and named.

    Only those: a ValueError out of the computation is a defect, and its traceback is wanted.
    """

    @functools.wraps(verb)
    def checked(*args: Words.args, **options: Words.kwargs) -> Result:
        try:
            return verb(*args, **options)
        except (CampaignFileError, ResultFileError) as error:
            told = str(error)
            if error.misplaced is not None:
                told += "\n" + fault_picture(error.misplaced, options)
            raise click.ClickException(told) from error

    return checked
