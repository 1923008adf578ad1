"""Arguments of the library's functions: paths and numbers; and the progress of a call."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from os import PathLike
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from analysis.progress import Progress
from app.terminal.progress import progress as bars

File = str | PathLike[str]


def as_path(file: File) -> Path:
    """Path of a file or folder; TypeError for what is none, with what to do for a result in memory."""
    try:
        return Path(file)
    except TypeError as error:
        kind = type(file)
        made = (
            "; write it with out=FOLDER, and name that folder" if kind.__module__.startswith("app.stages") else ""
        )
        raise TypeError(f"a path is wanted (str or pathlib.Path), not {kind.__name__}{made}") from error


def numbers(values: float | Sequence[float]) -> tuple[float, ...]:
    """Return one number or several as several."""
    return tuple(float(one) for one in np.atleast_1d(np.asarray(values, float)))


@contextmanager
def computing(*, shown: bool | None) -> Iterator[Progress]:
    """Yield a progress callable, BLAS held to one thread: the matrices are small and many."""
    with threadpool_limits(1), bars(shown=shown) as report:
        yield report
