"""What a verb says, and where: its result on stdout; progress, notes and the closing line on stderr."""

import functools
import json
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any, TypeVar

import click

from analysis.progress import Progress
from app.terminal.progress import progress

Result = TypeVar("Result")


@dataclass(frozen=True)
class Output:
    """How much a verb was asked to say.

    Attributes
    ----------
    as_json : bool
        The result as JSON, instead of a table for people.
    quiet : bool
        Neither progress nor table nor closing line. What a user has to know is told all the same.
    """

    as_json: bool
    quiet: bool

    def progress(self) -> AbstractContextManager[Progress]:
        """Context with a callable (stage, share done) that draws bars where somebody looks."""
        return progress(shown=not self.quiet)

    def result(self, record: Callable[[], Any], show: Callable[[], object] | None = None) -> None:
        """Print what `record` returns as JSON, or let `show` print it for people."""
        if self.as_json:
            click.echo(json.dumps(record(), indent=1, allow_nan=False))
        elif show is not None and not self.quiet:
            show()

    def note(self, text: str) -> None:
        """Tell what has to be known before the result is trusted."""
        click.echo(f"note: {text}", err=True)

    def summary(self, line: str) -> None:
        """Say in a line what came of it."""
        if not self.quiet:
            click.echo(line, err=True)

    def failure(self, line: str) -> None:
        """Say why it was not done, however quiet the rest."""
        click.echo(line, err=True)


def output_options(printed: str) -> Callable[[Callable[..., Result]], Callable[..., Result]]:
    """Give a verb --quiet and --json, which prints `printed`; it takes both as one argument, `output`."""

    def add(verb: Callable[..., Result]) -> Callable[..., Result]:
        @functools.wraps(verb)
        def speaking(*args: Any, as_json: bool, quiet: bool, **options: Any) -> Result:
            return verb(*args, output=Output(as_json, quiet), **options)

        json_option = click.option("--json", "as_json", is_flag=True, help=f"Print {printed} as JSON.")
        quiet_option = click.option("-q", "--quiet", is_flag=True, help="Only say what went wrong.")
        return quiet_option(json_option(speaking))

    return add
