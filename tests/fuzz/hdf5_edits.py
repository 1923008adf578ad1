"""An HDF5 file of Flexura's changed and sealed anew, as another version or a script leaves it."""

import tempfile
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from app.files.hdf5_file import BLOCK, sealed


def edited(whole: bytes, rng: np.random.Generator) -> bytes:
    """Return a copy with one to three arrays, groups or attributes removed, renamed, or given other values."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "edited.h5"
        path.write_bytes(whole)
        with h5py.File(path, "r+") as file:
            for _ in range(int(rng.integers(1, 4))):
                _edit(file, rng)
        return b"".join(sealed(path.read_bytes()[BLOCK:]))


def _edit(file: h5py.File, rng: np.random.Generator) -> None:
    places: list[str] = []
    file.visit(places.append)
    attributes = [(held, name) for held in (file, *(file[place] for place in places)) for name in held.attrs]
    if attributes and rng.random() < 0.3:
        held, name = attributes[int(rng.integers(len(attributes)))]
        _replace(held.attrs, name, held.attrs[name], rng)
        return
    place = places[int(rng.integers(len(places)))] if places else ""
    if place and isinstance(file[place], h5py.Dataset):
        _replace(file, place, file[place][()], rng)
    elif place:
        del file[place]


def _replace(held: Any, name: str, value: Any, rng: np.random.Generator) -> None:
    """Put another value in the place of one, or none."""
    if isinstance(value, bytes | str):
        text = value.decode() if isinstance(value, bytes) else value
        cut = text[: int(rng.integers(len(text) + 1))]
        others: list[Any] = [
            cut,
            "",
            "[]",
            "{}",
            "null",
            "[[[1]]]",
            '{"inputs": 3}',
            text.replace("1", "1e999"),
            7,
        ]
    else:
        array = np.asarray(value)
        others = [
            np.full(array.shape, np.nan),
            np.zeros_like(array),
            -array if array.dtype.kind in "ifc" else array.astype(float),
            array[None],
            array.ravel(),
            array[:1] if array.ndim else np.zeros(3),
            array[..., :0] if array.ndim else np.array(1e308),
            array.astype(complex) * 1j,
            array.astype("S4") if array.ndim == 0 else np.zeros((2, 2), "i1"),
            np.full(array.shape, 1e308),
            "text",
        ]
    new = others[int(rng.integers(len(others) + 1)) - 1] if rng.random() < 0.9 else None
    del held[name]
    if new is not None:
        held[name] = new
