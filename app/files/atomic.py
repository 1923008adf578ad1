"""Files that are either whole or not there.

A result is written to ``NAME.part`` in its own folder, closed, forced to the disk and only then
renamed: a process killed at any moment leaves the old file, the new one, or a ``.part`` that no
reader looks at. One HDF5 file kept open and appended to does not survive a kill (the whole file may
refuse to open again), which is why nothing is ever written in place.

Files that are written together: all of them, or none.
"""

import json
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import h5py

from app.files.bad_file import ResultFileError
from app.files.disk_room import reason, unwritten, write_whole
from app.files.hdf5_file import hdf5_image, sealed

PARTIAL = ".part"


@contextmanager
def atomic_path(target: Path) -> Iterator[Path]:
    """Yield a path to write to, which takes the name `target` when the block ends well.

    Parameters
    ----------
    target : Path
        The finished file; its folder is made if need be. An older file of that name is replaced.

    Yields
    ------
    Path
        ``target`` with ``.part`` added: the caller writes and closes it. If the block raises, it is
        removed and `target` stays as it was.

    Raises
    ------
    UnwrittenFileError
        For what the disk refuses, be it in the block.
    """
    with unwritten(target), _partial(target) as partial:
        yield partial
        force_to_disk(partial)


@contextmanager
def atomic_hdf5(target: Path, *, shared: bool = False) -> Iterator[h5py.File]:
    """Yield an HDF5 file open for writing; sealed, it takes the name `target` when the block ends well.

    Parameters
    ----------
    shared : bool
        Whether several processes may write the same at once, as a model that each of them needs; the last stays.

    Yields
    ------
    h5py.File
        In memory.

    Raises
    ------
    UnwrittenFileError
        Where it fits neither into memory nor onto the disk.
    """
    with unwritten(target), hdf5_image() as (file, made):
        yield file
    write_bytes(target, *sealed(made[0]), shared=shared)


def write_bytes(target: Path, *parts: bytes, shared: bool = False) -> None:
    """Write `parts` one after another, whole or not at all; `shared` as of `atomic_hdf5`.

    Raises
    ------
    UnwrittenFileError
        Where it cannot be written, with how much room is missing.
    """
    with unwritten(target, sum(map(len, parts))), _partial(target, f".{os.getpid()}" * shared) as partial:
        write_whole(partial, parts)


@contextmanager
def _partial(target: Path, own: str = "") -> Iterator[Path]:
    """Yield the path that takes the name `target` when the block ends well, and is removed when it does not."""
    target.parent.mkdir(parents=True, exist_ok=True)
    partial = target.with_name(target.name + own + PARTIAL)
    try:
        yield partial
        partial.replace(target)
    except BaseException:
        with suppress(OSError):  # the disk's first answer is the one that says what is wrong
            partial.unlink(missing_ok=True)
        raise
    force_folder_to_disk(target.parent)


def write_text(target: Path, text: str) -> None:
    """Write `text` as UTF-8 with the line ends it has, whole or not at all."""
    write_bytes(target, text.encode())


def write_json(target: Path, value: object) -> None:
    """Write `value` as JSON, whole or not at all; ValueError for NaN and infinity, which JSON lacks."""
    write_text(target, json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False) + "\n")


def force_to_disk(path: Path) -> None:
    """Return when the bytes of a closed file are on the disk, not only in the system's cache."""
    handle = os.open(path, os.O_RDWR)  # Windows flushes only what is open for writing
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def force_folder_to_disk(folder: Path) -> None:
    """Return when the names in a folder are on the disk; a system that cannot is left alone."""
    if os.name == "nt":  # Windows opens no folder as a file, and journals its renames
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


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
