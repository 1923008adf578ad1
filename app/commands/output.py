"""Output of a verb: its result on stdout; progress, notes and the closing line on stderr."""

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
    """Output of a verb, by --json and --quiet.

    Attributes
    ----------
    as_json : bool
        Whether the result is printed as JSON instead of a table.
    quiet : bool
        No progress, table or closing line; notes and errors are printed nevertheless.
    """

    as_json: bool
    quiet: bool

    def progress(self) -> AbstractContextManager[Progress]:
        """Context manager whose value, called with (stage, share done), draws progress bars on a terminal."""
        return progress(shown=not self.quiet)

    def result(self, record: Callable[[], Any], show: Callable[[], object] | None = None) -> None:
        """Print the value of `record` as JSON, or call `show` to print a table."""
        if self.as_json:
            click.echo(json.dumps(record(), indent=1, allow_nan=False))
        elif show is not None and not self.quiet:
            show()

    def note(self, text: str) -> None:
        """Print a note that is important for the use of the result."""
        click.echo(f"note: {text}", err=True)

    def summary(self, line: str) -> None:
        """Print the closing line, unless quiet."""
        if not self.quiet:
            click.echo(line, err=True)

    def failure(self, line: str) -> None:
        """Print an error, even if quiet."""
        click.echo(line, err=True)


def output_options(printed: str) -> Callable[[Callable[..., Result]], Callable[..., Result]]:
    """Add --quiet and --json, which prints `printed`, to a verb, which receives both as `output`."""

    def add(verb: Callable[..., Result]) -> Callable[..., Result]:
        @functools.wraps(verb)
        def speaking(*args: Any, as_json: bool, quiet: bool, **options: Any) -> Result:
            return verb(*args, output=Output(as_json, quiet), **options)

        json_option = click.option("--json", "as_json", is_flag=True, help=f"Print {printed} as JSON.")
        quiet_option = click.option("-q", "--quiet", is_flag=True, help="Print notes and errors only.")
        return quiet_option(json_option(speaking))

    return add
