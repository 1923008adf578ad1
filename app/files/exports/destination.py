"""Files that are written together: all of them, or none."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from app.files.atomic import PARTIAL, force_folder_to_disk, force_to_disk
from app.files.bad_file import ResultFileError
from app.files.disk_room import reason

OLD = PARTIAL + ".old"


@contextmanager
def written_together(folder: Path, names: tuple[str, ...]) -> Iterator[tuple[Path, ...]]:
    """Yield a path to write to for each name; they take their names when the block ends well.

    Yields
    ------
    tuple of Path
        In the order of `names`.

    Raises
    ------
    ResultFileError
        Where the folder cannot be written, or one of the names is taken by what is no file.

    Notes
    -----
    Where one file cannot take its name, those before it give theirs back, and what stood there before stands there
    again. A computer that stops between two of them leaves some new and some old files, each of them whole, and
    the old content of the new ones beside them (``.part.old``).
    """
    targets = [folder / name for name in names]
    parts = [target.with_name(target.name + PARTIAL) for target in targets]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        try:
            yield tuple(parts)
            for part in parts:
                force_to_disk(part)
            _renamed(parts, targets)
        finally:
            for part in parts:
                part.unlink(missing_ok=True)
        force_folder_to_disk(folder)
    except OSError as error:
        raise ResultFileError(f"{folder}: {reason(error, targets[0])}; --out names the folder") from error


def _renamed(parts: list[Path], targets: list[Path]) -> None:
    """Rename all or none: what stands in the way is kept beside it until all have their names."""
    kept = [target.with_name(target.name + OLD) for target in targets]
    done: list[Path] = []
    try:
        for part, target, old in zip(parts, targets, kept, strict=True):
            if target.exists():
                _keep(target, old)
            part.replace(target)
            done.append(target)
    except BaseException:
        for target, old in zip(done, kept, strict=False):
            if old.exists():
                old.replace(target)
            else:
                target.unlink()
        raise
    finally:
        for old in kept:
            old.unlink(missing_ok=True)


def _keep(target: Path, old: Path) -> None:
    """Give a file a hard link, or a copy where the file system has no hard links."""
    old.unlink(missing_ok=True)
    try:
        os.link(target, old)
    except OSError:
        shutil.copy2(target, old)
