"""An untrusted HDF5 file, opened and checked: complete, without external links, of a size that fits its bytes.

Read are arrays of plain numbers and texts, all of them in the file itself. HDF5 follows links into other files,
reads the bytes of any file it is named as an array's storage, and makes an array of any size out of nothing. None
of that is in a file of Flexura's, and a file from others must not have it.
"""

import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import prod
from pathlib import Path

import h5py
from h5py import h5a, h5d, h5o, h5z

from app.files.bad_file import ResultFileError
from app.files.hdf5_bytes import BrokenSealError, opened_image, opened_seal


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
