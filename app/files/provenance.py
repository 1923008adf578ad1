"""Where a result came from: versions, input hashes, settings and seed, inside every result file.

No time of day is kept: the same inputs, settings and versions give the same bytes.
"""

import hashlib
import json
import platform
from collections.abc import Mapping
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import h5py

import analysis
from app.files.parsed_text import parse_json

PACKAGES = ("numpy", "scipy", "h5py", "torch", "scikit-fem")
NAME = "provenance"


def sha256(path: Path) -> str:
    """Hexadecimal SHA-256 of a file, read in pieces."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def provenance(
    inputs: Mapping[str, str], settings: Mapping[str, Any] | None = None, seed: int | None = None
) -> dict[str, Any]:
    """Describe what a result was made from and with.

    Parameters
    ----------
    inputs : mapping
        SHA-256 of every input, by name (``Campaign.hashes``, or made with `sha256`).
    settings : mapping, optional
        Everything that was chosen; must be writable as JSON.
    seed : int, optional
        Where randomness was involved.

    Returns
    -------
    dict
        ``flexura``, ``python``, ``packages``, ``inputs``, ``settings`` and ``seed``, ready for JSON.
    """
    return {
        "flexura": analysis.__version__,
        "python": platform.python_version(),
        "packages": _versions(),
        "inputs": dict(sorted(inputs.items())),
        "settings": dict(settings or {}),
        "seed": seed,
    }


def _versions() -> dict[str, str]:
    """Return the versions of `PACKAGES` that are installed: a lean environment has no torch."""
    found = {}
    for name in PACKAGES:
        with suppress(PackageNotFoundError):
            found[name] = version(name)
    return found


def stamp(group: h5py.Group, made_from: Mapping[str, Any]) -> None:
    """Store a provenance in an HDF5 file or group, as one JSON string named ``provenance``.

    A dataset, not an attribute: the hashes of a few hundred sweeps pass the 64 KiB an attribute holds.
    """
    group.create_dataset(NAME, data=json.dumps(made_from, allow_nan=False))


def read_stamp(group: h5py.Group) -> dict[str, Any]:
    """Read back what `stamp` stored; KeyError if the file carries none."""
    stored: dict[str, Any] = parse_json(group[NAME].asstr()[()])
    return stored
