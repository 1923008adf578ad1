"""HDF5 files: made and sealed in memory; untrusted ones opened and checked, whose size fits their bytes.

Read are arrays of plain numbers and texts, all of them in the file itself. HDF5 follows links into other files,
reads the bytes of any file it is named as an array's storage, and makes an array of any size out of nothing. None
of that is in a file of Flexura's, and a file from others must not have it.

Where HDF5 cannot write a file of its own, it keeps it and tries again at the next close, on memory that is no
longer there: on a full disk the program ended by SIGSEGV. And it waits for a disk that hangs with Python's
interpreter lock held, so that all threads stand still.

Images are made with HDF5's own driver for memory: under 15 limits of memory it refused without a crash, h5py's for
Python's files (`io.BytesIO`) crashed at one of them. Bytes are read through the latter, four times as fast and
without a copy: there is nothing left to write at the end, and none of 21 limits made it crash.

The seal is a digest of a file's own bytes, at its head: any change after the file was written is seen before it is
read.

HDF5 leaves the first 512 bytes of a file free (the user block). Flexura keeps there, as text, the
SHA-256 of all bytes after them. A reader that compares it first never hands damaged bytes to the HDF5 library,
which runs into endless loops, crashes or wrong numbers on them.

Frozen values as groups of an HDF5 file: one rule for every dataclass of arrays.

Arrays and tuples of numbers become datasets, numbers and strings attributes, tuples of strings a JSON
attribute, dataclasses sub-groups, tuples of dataclasses numbered sub-groups. Reading goes by the type hints and
makes the value anew, so that its own checks run; nothing in the file decides what is built.
"""

import hashlib
import io
import json
import os
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import MISSING, fields, is_dataclass
from math import prod
from pathlib import Path
from typing import Any, TypeVar, get_args, get_origin, get_type_hints
from uuid import uuid4

import h5py
import numpy as np
from h5py import h5a, h5d, h5o, h5z

from app.files.bad_file import ResultFileError
from app.files.parsed_text import parse_json

GROWTH_STEP = 1 << 20
"""Bytes by which an image grows: at HDF5's own 64 kB a large one is moved a thousand times."""


@contextmanager
def hdf5_image() -> Iterator[tuple[h5py.File, list[bytes]]]:
    """Yield a file open for writing, and a list that holds its bytes once the block has ended well.

    Raises
    ------
    MemoryError
        Where it does not fit into memory.
    """
    made: list[bytes] = []
    try:
        with h5py.File(_name(), "w", driver="core", backing_store=False, block_size=GROWTH_STEP) as file:
            yield file, made
            file.flush()
            made.append(file.id.get_file_image())
    except (OSError, RuntimeError) as error:
        if "unable to allocate" in str(error):  # HDF5's own words; h5py raises OSError for whatever it says
            raise MemoryError("HDF5 was given none") from error
        raise


def opened_image(content: bytes) -> h5py.File:
    """Open the bytes of a file for reading, without a copy of them.

    Raises
    ------
    OSError
        For bytes of another kind, or damaged.
    """
    return h5py.File(io.BytesIO(content))


def _name() -> str:
    """Return a name of which there is no file.

    HDF5 tries to open it nevertheless, which could hang in a current folder on a lost network share: below what is
    no folder the system answers at once. Two images of one name would be one to HDF5.
    """
    return f"{os.devnull}/{uuid4()}"


BLOCK = 512
"""Bytes of the user block; HDF5 allows 512, 1024, 2048, ..."""
MARK = b"flexura-sealed/1 sha256 "
HDF5 = b"\x89HDF\r\n\x1a\n"


class BrokenSealError(ValueError):
    """The bytes of a file are not those that were written."""


def sealed(image: bytes) -> tuple[bytes, bytes]:
    """Return what a file consists of: its first 512 bytes, with the digest of the image, and the image.

    HDF5 finds an image that begins at byte 512 as it does one at byte 0.
    """
    return _block(hashlib.sha256(image).hexdigest()), image


def opened_seal(content: bytes) -> bool:
    """Whether the bytes of a file carry the digest they should.

    Returns
    -------
    bool
        False for an HDF5 file without one: of another program, or of a version that wrote none.

    Raises
    ------
    BrokenSealError
        Where the digest is not that of the bytes, and for what is no HDF5 file.
    """
    if content.startswith(HDF5):
        return False
    if not content.startswith(MARK):
        raise BrokenSealError("no HDF5 file" if content else "an empty file")
    if content[:BLOCK] != _block(hashlib.sha256(memoryview(content)[BLOCK:]).hexdigest()):
        raise BrokenSealError("damaged, cut short or edited: its bytes do not give the SHA-256 it carries")
    return True


def _block(digest: str) -> bytes:
    return (MARK + digest.encode() + b"\n").ljust(BLOCK, b"\0")


class Hdf5FileError(ValueError):
    """A file cannot be read, or must not; the message says what was seen and what is allowed."""


ALLOWED_ARRAY_BYTES = 64_000_000
"""Bytes of arrays that any file may hold, however small it is itself."""
LARGEST_EXPANSION = 100
"""Bytes of arrays to a byte of the file, beyond that."""
MOST_OBJECTS = 100_000
"""Groups and arrays: every one costs memory and time before its contents are known."""
LARGEST_CHUNK = 16_000_000
"""Bytes of one compressed piece of an array."""
LARGEST_ATTRIBUTE = 1_000_000
"""Bytes of an attribute."""
FILTERS = frozenset({h5z.FILTER_DEFLATE, h5z.FILTER_SHUFFLE})


class ForeignContentsError(ValueError):
    """An HDF5 file holds what no file of results does; the message names the place."""


def require_plain(file: h5py.File, size: int) -> None:
    """Look through a whole file before anything is read from it.

    Parameters
    ----------
    size : int
        Of the file, bytes.

    Raises
    ------
    ForeignContentsError
        For a link that is not a plain one, arrays that lie in other files or would be larger than `size` lets
        expect, and types other than numbers and single texts.
    """
    left = ALLOWED_ARRAY_BYTES + LARGEST_EXPANSION * size
    groups = [file["/"]]
    known = {h5o.get_info(file.id).addr}
    _require_attributes(file["/"])
    while groups:
        group = groups.pop()
        for name in group:
            place = f"{group.name.rstrip('/')}/{name}"
            if not isinstance(group.get(name, getlink=True), h5py.HardLink):
                raise ForeignContentsError(f"{place} is a link to elsewhere")
            held = group[name]
            address = h5o.get_info(held.id).addr
            if address in known or len(known) > MOST_OBJECTS:
                raise ForeignContentsError(f"{place} occurs twice, or there are over {MOST_OBJECTS} like it")
            known.add(address)
            _require_attributes(held)
            if isinstance(held, h5py.Group):
                groups.append(held)
            elif isinstance(held, h5py.Dataset):
                needed = _array_bytes(held)
                if needed > left:
                    raise ForeignContentsError(f"{place} takes {needed} bytes; {left} are allowed in this file")
                left -= needed
                _require_stated_size(held)
            else:
                raise ForeignContentsError(f"{place} is neither an array nor a group")


def _array_bytes(array: h5py.Dataset) -> int:
    """Size of an array; ForeignContentsError where it is not all in this file, or of another type."""
    made = array.id.get_create_plist()  # looked at first: asking a virtual array for its shape opens other files
    if made.get_layout() == h5d.VIRTUAL or made.get_external_count():
        raise ForeignContentsError(f"{array.name} lies in other files")
    if array.shape is None:
        raise ForeignContentsError(f"{array.name} is empty")
    _require_type(array.name, array.dtype, array.shape)
    return int(prod(array.shape) * array.dtype.itemsize)


def _require_stated_size(array: h5py.Dataset) -> None:
    """Unpack compressed chunks up to the size they should have; HDF5 itself would unpack whatever there is."""
    if array.chunks is None:
        return
    made, piece = array.id.get_create_plist(), prod(array.chunks) * array.dtype.itemsize
    filters = [made.get_filter(n)[0] for n in range(made.get_nfilters())]
    if piece > LARGEST_CHUNK or len(set(filters)) != len(filters) or not FILTERS.issuperset(filters):
        raise ForeignContentsError(f"{array.name} is packed in pieces of {piece} bytes by filters {filters}")
    stored: list[h5d.StoreInfo] = []
    array.id.chunk_iter(stored.append)
    for chunk in stored if filters else []:
        if chunk.size > piece + piece // 100 + 1024:
            raise ForeignContentsError(f"{array.name} holds {chunk.size} bytes for a piece of {piece}")
        _, packed = array.id.read_direct_chunk(chunk.chunk_offset)
        if array.compression and chunk.filter_mask == 0 and len(_unpacked(packed, piece + 1)) != piece:
            raise ForeignContentsError(f"{array.name} holds a piece that does not unpack into {piece} bytes")


def _unpacked(packed: bytes, most: int) -> bytes:
    try:
        return zlib.decompressobj().decompress(packed, most)
    except zlib.error:
        return b""


def _require_attributes(held: h5py.HLObject) -> None:
    for name in held.attrs:
        attribute = h5a.open(held.id, name.encode("utf-8", "surrogateescape"))
        place = f"{held.name}, attribute {name},"
        if attribute.shape is None or attribute.get_storage_size() > LARGEST_ATTRIBUTE:
            raise ForeignContentsError(f"{place} is empty or longer than {LARGEST_ATTRIBUTE} bytes")
        _require_type(place, attribute.dtype, attribute.shape)


def _require_type(place: str, kind: object, shape: tuple[int, ...]) -> None:
    text = h5py.check_string_dtype(kind)
    if (text is None and getattr(kind, "kind", "O") not in "biufc") or (text is not None and shape != ()):
        raise ForeignContentsError(f"{place} is of type {kind}, neither numbers nor one text")


@contextmanager
def opened_hdf5(path: Path, unsealed: Callable[[Path], None] | None = None) -> Iterator[h5py.File]:
    """Yield a file to read from, whose bytes are those that were written and whose contents are plain.

    Parameters
    ----------
    unsealed : callable, optional
        Makes sure that a file without a digest can be read at all, or raises ValueError; such files are refused
        unless it is given.

    Raises
    ------
    Hdf5FileError
        For all that is wrong with the file, and for whatever the block runs into that reads it: a file of another
        kind, or of another version.
    """
    try:
        with _in_memory(path, unsealed) as (file, size):
            require_plain(file, size)
            yield file
    except (Hdf5FileError, ResultFileError):
        raise
    except FileNotFoundError as error:
        raise Hdf5FileError("no such file") from error
    except Exception as error:
        lacks = f"lacks {error}" if isinstance(error, KeyError) else str(error)
        raise Hdf5FileError(f"{lacks}; allowed: a file as Flexura wrote it") from error


@contextmanager
def _in_memory(path: Path, unsealed: Callable[[Path], None] | None) -> Iterator[tuple[h5py.File, int]]:
    """Yield the file, and its size in bytes; HDF5 is given the bytes that were checked, never the disk.

    It would wait for a disk that hangs with Python's interpreter lock held, and the file could change after it was
    checked.
    """
    content = path.read_bytes()
    if not opened_seal(content):
        if unsealed is None:
            raise BrokenSealError("carries no SHA-256 of its bytes: of an earlier version or another program")
        unsealed(path)
    with opened_image(content) as file:
        yield file, len(content)


@contextmanager
def result_file(path: Path, verb: str) -> Iterator[h5py.File]:
    """Yield a result to read from, see `opened_hdf5`; ResultFileError says which verb makes it again."""
    try:
        with opened_hdf5(path) as file:
            yield file
    except Hdf5FileError as error:
        message = f"{path}: not a readable {path.name}: {error}; make it again: flexura {verb}"
        raise ResultFileError(message) from error


Value = TypeVar("Value")


def _row_of(hint: Any) -> Any:
    """Return the dataclass of which a type hint is a tuple; None for other hints."""
    args = get_args(hint)
    return args[0] if get_origin(hint) is tuple and args and is_dataclass(args[0]) else None


def write_value(group: h5py.Group, value: Any) -> None:
    """Write a dataclass into an empty group."""
    for field in fields(value):
        item = getattr(value, field.name)
        if item is None:
            continue  # what may be lacking has None for its default
        if is_dataclass(item):
            write_value(group.create_group(field.name), item)
        elif isinstance(item, tuple) and any(is_dataclass(part) for part in item):
            rows = group.create_group(field.name)
            for place, part in enumerate(item):
                write_value(rows.create_group(f"{place:04d}"), part)
        elif isinstance(item, np.ndarray):
            # Measured numbers lose a fifth of their size to gzip, in ten times the time; counts lose nearly all.
            packed = item.size > 4096 and item.dtype.kind not in "fc"
            group.create_dataset(
                field.name, data=item, compression="gzip" if packed else None, shuffle=packed or None
            )
        elif isinstance(item, tuple) and not all(isinstance(part, str) for part in item):
            group.create_dataset(field.name, data=np.array(item))
        elif isinstance(item, tuple):
            group.attrs[field.name] = json.dumps(item)
        else:
            group.attrs[field.name] = item


def read_value(group: h5py.Group, kind: type[Value]) -> Value:
    """Read a dataclass of type `kind`; ValueError where the group holds something else."""
    hints = get_type_hints(kind)
    parts: dict[str, Any] = {}
    for field in fields(kind):  # type: ignore[arg-type]
        optional = () if _row_of(hints[field.name]) else get_args(hints[field.name])
        wanted = next((one for one in optional if is_dataclass(one)), hints[field.name])
        if field.default is not MISSING and field.name not in group and field.name not in group.attrs:
            continue  # the file was written before there was such a field
        try:
            if is_dataclass(wanted):
                parts[field.name] = read_value(group[field.name], wanted)  # type: ignore[arg-type]
            elif (row := _row_of(hints[field.name])) is not None:
                rows = group.get(field.name, {})  # empty ones are stored as text
                parts[field.name] = tuple(read_value(rows[place], row) for place in sorted(rows))
            elif get_origin(wanted) is tuple and str in get_args(wanted):
                parts[field.name] = tuple(str(part) for part in parse_json(group.attrs[field.name]))
            elif get_origin(wanted) is tuple:
                parts[field.name] = tuple(group[field.name][()].tolist())
            elif wanted in (int, float, str, bool):
                parts[field.name] = wanted(group.attrs[field.name])
            else:
                parts[field.name] = held = group[field.name][()]
                if np.asarray(held).dtype.kind not in "biufc":
                    raise ValueError(
                        f"{group.name}: {field.name!r} is of type {np.asarray(held).dtype}; allowed: numbers"
                    )
        except (KeyError, TypeError) as error:
            raise ValueError(f"{group.name} lacks a readable {field.name!r}") from error
    try:
        return kind(**parts)
    except ValueError as error:
        raise ValueError(f"{group.name}: {error}") from error
