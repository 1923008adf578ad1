"""Workers of a Dask cluster as one `Executor`: those that could give another result are refused by name.

Dask distributes the tasks and gives those of a dead worker to another. What it cannot know is checked here before
the first task: that every worker runs this code with these libraries, sees the folder of the results, has one
thread (a task takes the whole process: BLAS, signals, memory) and enough memory. A worker that joins later is
checked by its first task.

That the code is the same is seen by its digest: the version alone does not tell, as of a checkout it stays the
same while files change.
"""

import hashlib
import logging
import os
import re
import uuid
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import CancelledError, Executor, Future
from contextlib import contextmanager, suppress
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

from threadpoolctl import threadpool_limits

from analysis.progress import Progress
from app.files.bad_file import ResultFileError
from app.files.parsed_text import parse_json, read_text
from app.files.results.run_record import versions

Words = ParamSpec("Words")
Result = TypeVar("Result")

RETRIES = 2
"""Of a task that raised: a worker may have lost its disk or be out of memory while another has both. A task whose
worker died is not counted: Dask gives it away three times more (its ``allowed-failures``)."""
FIRST_CONTACT = 10.0
"""Seconds within which a scheduler that is there answers, also over a slow network."""
FIRST_WORKER = 60.0
"""Seconds within which a first worker has to be there: a process starts in a few, a job of a batch system that is
queued for longer is better waited for before."""
ADDRESS = re.compile(r"(?:(?:tcp|tls|ws|wss)://)?(?:[\w.-]+|\[[0-9a-fA-F:]+\]):(?P<port>\d{1,5})")
ALLOWED = "allowed: tcp://HOST:PORT, as dask scheduler prints it, or the file that its --scheduler-file wrote"
LARGEST_SCHEDULER_FILE = 1_000_000
"""Bytes of a scheduler's file, which lists its workers."""
START = "start it with: dask worker {address} --nthreads 1 --memory-limit {limit}"


PACKAGES_OF_OURS = ("analysis", "app", "drivers", "flexura", "simulation")
CARRIES = {".py", ".in", ".css", ".js", ".html"}
"""Endings of what decides how Flexura works: modules, and the templates beside them."""


@cache
def code_digest() -> str:
    """SHA-256 of all modules of Flexura as they lie on this machine's disk, and of their names, once a process."""
    found = hashlib.sha256()
    for package in PACKAGES_OF_OURS:
        spec = find_spec(package)
        if spec is None or spec.origin is None:
            raise ImportError(f"{package}: not installed beside the others")
        root = Path(spec.origin).parent
        for path in sorted(root.rglob("*"), key=lambda one: one.relative_to(root).as_posix()):
            if path.suffix in CARRIES and path.is_file():
                name = f"{package}/{path.relative_to(root).as_posix()}"
                found.update(f"{name}\0{path.stat().st_size}\0".encode())
                found.update(path.read_bytes())
    return found.hexdigest()


def running() -> dict[str, str]:
    """Return what runs here, by name: the digest of Flexura's code, the versions of Python and of libraries."""
    return dict(_running())


@cache
def _running() -> dict[str, str]:
    """Find it once a process: every task of a cluster asks."""
    known = versions()
    libraries = {name: str(one) for name, one in known["packages"].items()}
    return {"flexura": known["flexura"], "code": code_digest(), "python": known["python"], **libraries}


def unlike(ours: dict[str, str], theirs: dict[str, str]) -> str:
    """Say in which parts two machines run something else; empty where they do not."""
    names = [name for name in (*ours, *theirs) if ours.get(name) != theirs.get(name)]
    told = []
    for name in dict.fromkeys(names):
        seen, wanted = (one.get(name, "none")[:12] for one in (theirs, ours))
        told.append(f"{name} {seen} (here {wanted})")
    return ", ".join(told)


@contextmanager
def cluster_workers(
    address: str, folder: Path, memory: float, report: Progress, patience: float = FIRST_WORKER
) -> Iterator[Executor]:
    """Yield the workers of a cluster; what they have not begun when the block ends is taken back.

    Parameters
    ----------
    address : str
        Of its scheduler: ``tcp://HOST:PORT``, or the file that ``dask scheduler --scheduler-file`` writes.
    folder : Path
        Of the results; workers write into it, by the same path.
    memory : float
        Bytes that a task takes at most.
    patience : float
        Seconds that a first worker is waited for.

    Yields
    ------
    Executor

    Raises
    ------
    ResultFileError
        For a scheduler that does not answer, a worker that is refused, a cluster that went away.
    """
    client = _connected(address)
    try:
        report("workers", 0.0)
        _wait_for_a_worker(client, address, memory, patience)
        refused = _refused(client, address, folder, memory)
        if refused:
            raise ResultFileError(f"--cluster {address}: " + "; ".join(refused))
        report("workers", 1.0)
        executor = _ClusterExecutor(client.get_executor(pure=False, retries=RETRIES), running())
        try:
            yield executor
        except CancelledError as error:
            raise ResultFileError(
                f"--cluster {address}: it went away, or took its tasks back; what is finished stays: run this "
                "again to go on, there or with --workers"
            ) from error
        except _killed_worker() as error:
            raise ResultFileError(
                f"--cluster {address}: a task ended worker after worker (too little memory?): {error}; what is "
                "finished stays: run this again to go on"
            ) from error
        finally:
            executor.shutdown(wait=False)
    finally:
        with suppress(OSError):  # a cluster that is gone takes no leave
            client.close(timeout=FIRST_CONTACT)


class OtherCodeError(RuntimeError):
    """A worker runs other code than the process that gave it the task."""


class _ClusterExecutor(Executor):
    """Dask's executor, whose workers check themselves before every task."""

    def __init__(self, dask: Executor, ours: Mapping[str, str]) -> None:
        self._dask = dask
        self._ours = dict(ours)

    def submit(
        self, task: Callable[Words, Result], /, *args: Words.args, **kwargs: Words.kwargs
    ) -> Future[Result]:
        return self._dask.submit(on_worker, self._ours, task, *args, **kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End it; tasks not begun are taken back unless they are waited for."""
        with suppress(OSError):
            self._dask.shutdown(wait=wait and not cancel_futures)


def on_worker(
    ours: dict[str, str], task: Callable[Words, Result], /, *args: Words.args, **kwargs: Words.kwargs
) -> Result:
    """Do a task on a worker, with one BLAS thread; OtherCodeError where this process runs other code."""
    other = unlike(ours, running())
    if other:
        raise OtherCodeError(f"{_here()} runs other code: {other}")
    with threadpool_limits(1):
        return task(*args, **kwargs)


def state_of_worker(token: Path) -> tuple[dict[str, str], bool]:
    """Return what runs on a worker, and whether it sees a file."""
    return running(), token.is_file()


def _here() -> str:
    """Name of the worker that this is."""
    return str(import_module("distributed").get_worker().address)


def _connected(address: str) -> Any:
    try:
        distributed = import_module("distributed")
    except ImportError as error:
        raise ResultFileError(
            f"--cluster {address}: the package distributed is not installed; install it with: "
            "pip install 'flexura[cluster]'"
        ) from error
    # Of what it logs nothing is for people: that it connects again, and tracebacks of a scheduler that is gone.
    for name in ("distributed", "distributed.client"):  # of the second Dask sets the level itself
        logging.getLogger(name).setLevel(logging.CRITICAL)
    where = _address_in(Path(address)) if Path(address).suffix == ".json" else address
    read = ADDRESS.fullmatch(where)
    if read is None or not 0 < int(read["port"]) < 65536:
        raise ResultFileError(f"--cluster {address}: {where} is no address; {ALLOWED}")
    try:
        return distributed.Client(where, timeout=FIRST_CONTACT, set_as_default=False)
    except (OSError, ValueError) as error:
        said = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise ResultFileError(f"--cluster {address}: no scheduler answers there ({said}); {ALLOWED}") from error


def _address_in(file: Path) -> str:
    """Return the address in a scheduler's file."""
    try:
        return str(parse_json(read_text(file, LARGEST_SCHEDULER_FILE))["address"])
    except FileNotFoundError as error:
        raise ResultFileError(
            f"--cluster {file}: there is no such file; it is made by: dask scheduler --scheduler-file {file}"
        ) from error
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ResultFileError(
            f"--cluster {file}: it holds no address of a scheduler ({error}); it is made by: dask scheduler "
            f"--scheduler-file {file}"
        ) from error


def _killed_worker() -> type[BaseException]:
    found: type[BaseException] = import_module("distributed").KilledWorker
    return found


def _wait_for_a_worker(client: Any, address: str, memory: float, patience: float) -> None:
    try:
        client.wait_for_workers(1, timeout=patience)
    except OSError as error:  # TimeoutError is one
        raise ResultFileError(
            f"--cluster {address}: no worker came within {patience:.0f} s; {_start(address, memory)}"
        ) from error


def _start(address: str, memory: float) -> str:
    place = f"--scheduler-file {address}" if Path(address).suffix == ".json" else address
    return START.format(address=place, limit=f"{memory / 1e9:.1f}GB")


def _refused(client: Any, address: str, folder: Path, memory: float) -> list[str]:
    """Return why workers cannot take part, each by its address."""
    told: dict[str, Any] = client.scheduler_info(n_workers=-1)["workers"]
    refused = [
        f"worker {name} has {one['nthreads']} threads, and one task at a time is safe; {_start(address, memory)}"
        for name, one in told.items()
        if one["nthreads"] != 1
    ]
    refused += [
        f"worker {name} may use {one['memory_limit'] / 1e9:.2g} GB, and a task takes {memory / 1e9:.2g}; "
        f"{_start(address, memory)}"
        for name, one in told.items()
        if 0 < (one["memory_limit"] or 0) < memory
    ]
    token = folder.resolve() / f".seen-{uuid.uuid4().hex}.part"
    token.touch()
    try:
        states = client.run(state_of_worker, token, on_error="return")
    finally:
        token.unlink(missing_ok=True)
    ours = running()
    for name, state in states.items():
        if isinstance(state, BaseException):
            refused.append(f"worker {name} runs other code ({state}); install the same Flexura there")
            continue
        other = unlike(ours, state[0])
        if other:
            refused.append(f"worker {name} runs other code: {other}; install the same Flexura there")
        elif not state[1]:
            refused.append(
                f"worker {name} does not see {os.fspath(token.parent)}; name a folder with --out that all "
                "machines share by the same path"
            )
    return refused
