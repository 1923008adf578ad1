"""Untrusted measurements, read by a separate process of limited time and memory, which leaves plain arrays.

On damaged bytes, readers of foreign formats crash, fill the memory or never end; here this gives a message.
"""

import json
import shutil
import sys
import tempfile
import traceback
import warnings
from collections.abc import Iterator, Sequence
from contextlib import suppress
from importlib import import_module
from pathlib import Path

import numpy as np

from app.files.bad_file import ResultFileError
from app.files.isolation import hold_memory, run_isolated
from app.files.measurements.columns import Columns, with_units_of_names
from app.files.measurements.complex_pairs import with_complex_pairs
from app.files.measurements.formats import FORMATS, by_content, format_of
from app.files.parsed_text import parse_json
from drivers.own_process import PROGRAM

LARGEST = 2_000_000_000
"""Bytes above which a file is refused."""
MEMORY = 8_000_000_000
"""Bytes of address space that a reader gets, where the system can hold it to that."""
NAME = "columns.json"
MOST_FILES, TOGETHER = 100, 64_000_000
"""Files, and their bytes, that one process reads: what they hold lies unpacked in a temporary folder meanwhile."""


def read_columns(path: Path) -> Columns:
    """Read a measurement.

    Parameters
    ----------
    path : Path

    Returns
    -------
    Columns

    Raises
    ------
    ResultFileError
        Where it is missing, too large, of no known format, damaged, or not read in time.
    """
    if path.is_dir():
        raise ResultFileError(f"{path}: a folder; name the files in it")
    if not path.is_file():
        raise ResultFileError(f"{path}: no such file")
    size = path.stat().st_size
    if size > LARGEST:
        raise ResultFileError(f"{path}: {size} bytes; at most {LARGEST} allowed: export a part of it")
    try:
        kind = format_of(path)
        if size == 0:
            raise ValueError("0 bytes, an empty file; export or copy it again")
        with tempfile.TemporaryDirectory(prefix="flexura-") as folder:
            run_isolated(__name__, [kind.name, str(path.resolve()), folder], size)
            return _collected(Path(folder))
    except ResultFileError:
        raise
    except ValueError as error:
        seen = by_content(path)
        if seen is not None and path.suffix.lower() not in seen.endings:
            raise ResultFileError(
                f"{path}: begins as a {seen.endings[0]} file does; give it that ending"
            ) from error
        raise ResultFileError(f"{path}: {error}") from error


def read_each(paths: Sequence[Path]) -> Iterator[Columns]:
    """Read measurements in their order, small ones many to a process, which takes 0.5 s to start.

    Parameters
    ----------
    paths : sequence of Path

    Yields
    ------
    Columns
        Of one file at a time.

    Raises
    ------
    ResultFileError
        As `read_columns`, for the first file that cannot be read.
    """
    waiting = list(paths)
    while waiting:
        batch = _small_ones(waiting)
        del waiting[: len(batch)]
        with tempfile.TemporaryDirectory(prefix="flexura-") as folder:
            places = [Path(folder) / str(number) for number in range(len(batch))]
            if len(batch) > 1:
                words = []
                for path, place in zip(batch, places, strict=True):
                    place.mkdir()
                    words += [format_of(path).name, str(path.resolve()), str(place)]
                with suppress(ValueError):  # the file at which the process ended is read alone, and says why
                    run_isolated(__name__, words, sum(path.stat().st_size for path in batch))
            for path, place in zip(batch, places, strict=True):
                try:
                    columns = _collected(place)
                except (OSError, ValueError):
                    columns = read_columns(path)
                shutil.rmtree(place, ignore_errors=True)
                yield columns


def _small_ones(paths: Sequence[Path]) -> list[Path]:
    """Return the files at the beginning that one process reads; a single one where that is no small file."""
    batch: list[Path] = []
    total = 0
    for path in paths[:MOST_FILES]:
        size = path.stat().st_size if path.is_file() else 0
        known = any(path.suffix.lower() in one.endings for one in FORMATS)
        total += size
        if not (size and known and total <= TOGETHER):
            break
        batch.append(path)
    return batch or [paths[0]]


def _collected(folder: Path) -> Columns:
    """Load what the other process left."""
    content = parse_json((folder / NAME).read_bytes())
    values = {
        name: np.load(folder / f"{number}.npy", allow_pickle=False) for number, name in enumerate(content["names"])
    }
    del content["names"]
    content |= {key: tuple(content[key]) for key in ("shared", "notes")}
    return with_complex_pairs(with_units_of_names(Columns(values, **content)))


def _read_into(kind: str, path: Path, folder: Path) -> None:
    reader = next(one.reader for one in FORMATS if one.name == kind)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        columns: Columns = import_module(f"app.files.measurements.{reader}").read(path)
    notes = dict.fromkeys(f"{path.name}: {' '.join(str(one.message).split())[:300]}" for one in told)
    for number, values in enumerate(columns.values.values()):
        np.save(folder / f"{number}.npy", values, allow_pickle=False)
    content = {
        "names": list(columns.values),
        "units": columns.units,
        "rates": columns.rates,
        "scalars": {name: value for name, value in columns.scalars.items() if np.isfinite(value)},
        "channels": columns.channels,
        "places": columns.places,
        "references": columns.references,
        "starts": {name: value for name, value in columns.starts.items() if np.isfinite(value)},
        "doubts": columns.doubts,
        "aliases": columns.aliases,
        "shared": columns.shared,
        "notes": [*columns.notes, *notes],
    }
    (folder / NAME).write_text(json.dumps(content), encoding="utf-8")


def _said(error: Exception, kind: str) -> str:
    """Message of a reader, in a line; of a library's own, which do not say what to do, with the next step."""
    words = " ".join(str(error).split()) or type(error).__name__
    origin = Path(traceback.extract_tb(error.__traceback__)[-1].filename)
    if origin.is_relative_to(PROGRAM / "app") or origin.is_relative_to(PROGRAM / "analysis"):
        return words
    article = "an" if kind[0] in "aeiou" else "a"
    return (
        f"cannot be read as {article} {kind.upper()} file ({words[:200]}); "
        "cut short or damaged? export or copy it again"
    )


if __name__ == "__main__":
    try:
        hold_memory(MEMORY)
        for begin in range(1, len(sys.argv), 3):
            _read_into(sys.argv[begin], Path(sys.argv[begin + 1]), Path(sys.argv[begin + 2]))
    except MemoryError:
        sys.exit(f"needs more than {MEMORY // 10**9} GB of memory: damaged, or export a part of it")
    except Exception as error:  # noqa: BLE001 (reported to the parent process)
        sys.exit(_said(error, sys.argv[begin]))
