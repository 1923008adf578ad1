"""Files that are written together: all of them, or none."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from app.files.atomic import atomic_path
from app.files.bad_file import ResultFileError


@contextmanager
def written_together(folder: Path, names: tuple[str, ...]) -> Iterator[tuple[Path, ...]]:
    """Yield a path to write to for each name; they take their names when the block ends well.

    Parameters
    ----------
    folder : Path
    names : tuple of str

    Yields
    ------
    tuple of Path
        In the order of `names`.

    Raises
    ------
    ResultFileError
        Where the folder cannot be written.
    """
    try:
        with ExitStack() as stack:
            yield tuple(stack.enter_context(atomic_path(folder / name)) for name in names)
    except OSError as error:
        raise ResultFileError(
            f"{folder}: cannot be written ({error.strerror}); name another with --out"
        ) from error
