"""Arguments of the library's functions: paths and numbers; and the progress of a call."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from os import PathLike
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from analysis.progress import Progress
from app.files.bad_file import UnsuitedOptionError
from app.terminal.progress import progress as bars

File = str | PathLike[str]


def as_path(file: File) -> Path:
    """Path of a file or folder."""
    return Path(file)


def require_range(keyword: str, values: Sequence[float], low: float, high: float, unit: str = "") -> None:
    """Raise UnsuitedOptionError for a number outside of what an argument allows, as the verb does."""
    for value in values:
        if not low <= value <= high:
            raise UnsuitedOptionError(f"{keyword} {value:g}{unit}: allowed is {low:g} to {high:g}{unit}")


def numbers(values: float | Sequence[float]) -> tuple[float, ...]:
    """Return one number or several as several."""
    return tuple(float(one) for one in np.atleast_1d(np.asarray(values, float)))


@contextmanager
def computing(*, shown: bool | None) -> Iterator[Progress]:
    """Yield a progress callable, BLAS held to one thread: the matrices are small and many."""
    with threadpool_limits(1), bars(shown=shown) as report:
        yield report
