"""A file read through in a process of its own: on damaged bytes HDF5 may crash, or go on for ever, deaf to Ctrl-C.

Only for files without a digest of their own bytes; with one, `app.files.seal` tells the damage.
"""

import os
import subprocess
import sys
from pathlib import Path

import h5py

from app.files.hdf5_contents import require_plain

PATIENCE = 8.0
"""Seconds that starting Python and reading a small file may take."""
SLOWEST = 10e6
"""Bytes per second that any disk gives."""


def require_readable(path: Path) -> None:
    """Raise ValueError where a file cannot be read to its end, in a time that fits its size."""
    limit = PATIENCE + path.stat().st_size / SLOWEST
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(entry or str(Path.cwd()) for entry in sys.path)}
    words = [sys.executable, "-m", __name__, str(path.resolve())]
    try:
        child = subprocess.run(  # noqa: S603 (this module itself, and a file's name)
            words, env=environment, stdin=subprocess.DEVNULL, capture_output=True, timeout=limit, check=False
        )
    except subprocess.TimeoutExpired as error:
        raise ValueError(f"damaged: not read after {limit:.0f} s") from error
    if child.returncode:
        told = child.stderr.decode(errors="replace").strip().splitlines()
        raise ValueError(f"damaged: {told[-1] if told else f'HDF5 crashed on it ({child.returncode})'}")


def _read_through(path: Path) -> None:
    with h5py.File(path) as file:
        require_plain(file, path.stat().st_size)
        places: list[str] = []
        file.visit(places.append)
        for held in (file, *(file[place] for place in places)):
            dict(held.attrs)
            if isinstance(held, h5py.Dataset):
                held[()]


if __name__ == "__main__":
    try:
        _read_through(Path(sys.argv[1]))
    except Exception as error:  # noqa: BLE001 (told to the parent)
        sys.exit(str(error))
