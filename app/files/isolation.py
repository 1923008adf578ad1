"""A file read completely in a separate process: on damaged bytes HDF5 may crash, or never end and ignore Ctrl-C.

Only for files without a digest of their own bytes; with one, `app.files.hdf5_file` detects damage.
"""

import math
import signal
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from drivers.interruptions import ENDING
from drivers.own_process import module_command, own_surroundings

START_SECONDS = 30.0
"""Seconds of processor time that starting Python and reading a small file may take."""
CLOCK_FACTOR = 4.0
"""Times as long it may take by the clock, from a slow network share or beside other programs."""
SLOWEST_DISK = 10e6
"""Bytes per second that any disk gives."""
POOLS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
SIGXCPU = 24
"""Signal that ends a process at its limit of processor time; Windows does not name it."""


class SlowReadError(ValueError):
    """A file was not read in the time that one of its size may take."""


def require_readable(path: Path) -> None:
    """Raise ValueError where a file cannot be read to its end, in a time that fits its size."""
    try:
        run_isolated(__name__, [str(path.resolve())], path.stat().st_size)
    except SlowReadError:
        raise
    except ValueError as error:
        raise ValueError(f"damaged: {error}") from error


def run_isolated(module: str, arguments: Sequence[str], size: int) -> None:
    """Run one of our modules on a file, in a process of its own.

    Parameters
    ----------
    module : str
        Its dotted name.
    arguments : sequence of str
        Of its command line.
    size : int
        Of the file, bytes: a larger one is given more time.

    Raises
    ------
    ValueError
        With the last line the process said, where it fails.
    SlowReadError
        Where it takes too long.
    """
    limit = START_SECONDS + size / SLOWEST_DISK
    # one thread: each of an algebra library's takes 40 MB of the address space that a reader may be held to
    environment = own_surroundings() | dict.fromkeys(POOLS, "1")
    words = module_command(module, *arguments)
    with subprocess.Popen(  # noqa: S603 (a module of ours, and a file's name)
        words, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    ) as child:
        try:
            _hold_time(child.pid, math.ceil(limit))
            said = child.communicate(timeout=CLOCK_FACTOR * limit)[1]
        except subprocess.TimeoutExpired as error:
            raise SlowReadError(
                f"not read within {CLOCK_FACTOR * limit:.0f} s: damaged, or on a slow disk; "
                "try again with a local copy"
            ) from error
        finally:
            child.kill()
    if child.returncode == -SIGXCPU:  # its own limit, set above
        raise SlowReadError(f"not read in {math.ceil(limit)} s of processor time: damaged")
    if -child.returncode in ENDING:  # a request to end that met the reader is meant for us
        signal.raise_signal(-child.returncode)
        raise ValueError("its reading was interrupted")
    if child.returncode:
        errors = said.decode(errors="replace").strip().splitlines()
        raise ValueError(errors[-1] if errors else f"its reader crashed on it ({child.returncode})")


def _hold_time(process: int, most: int) -> None:
    """Let a process have no more than `most` seconds of processor time, where the system can hold it to that."""
    try:
        from resource import RLIMIT_CPU, prlimit
    except ImportError:  # only Linux has such a limit for another process; elsewhere the clock's remains
        return
    with suppress(ProcessLookupError):
        prlimit(process, RLIMIT_CPU, (most, most + 1))


def hold_memory(most: int) -> None:
    """Let this process have no more than `most` bytes of address space, where the system can hold it to that."""
    try:
        import resource
    except ImportError:  # Windows has no such limit
        return
    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    limit = most if hard == resource.RLIM_INFINITY else min(most, hard)
    resource.setrlimit(resource.RLIMIT_AS, (limit, hard))


def _read_through(path: Path) -> None:
    import h5py  # here: readers of other formats need no HDF5 in their process

    from app.files.hdf5_file import require_plain

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
    except Exception as error:  # noqa: BLE001 (reported to the parent process)
        sys.exit(str(error))
