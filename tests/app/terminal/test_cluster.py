"""Workers of a Dask cluster: real ones on this machine; refusals by what a worker says of itself."""

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import as_completed
from pathlib import Path
from typing import Any

import pytest
from threadpoolctl import threadpool_info

from app.files.bad_file import ResultFileError
from app.terminal.cluster import PACKAGES_OF_OURS, cluster_workers, on_worker, running, unlike
from app.terminal.engine import Engine

distributed = pytest.importorskip("distributed")
ROOT = Path(__file__).resolve().parents[3]
MEMORY = 5e8


def silent(stage: str, share: float) -> None:
    """Workers coming."""


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    made = distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, memory_limit="1GB", dashboard_address=":0", silence_logs=50
    )
    with made:
        yield made


def blas_threads() -> list[int]:
    import scipy.linalg  # noqa: F401 (it loads BLAS)

    return [pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"]


def die_once(mark: Path) -> int:
    """Kill the worker that has this task first."""
    try:
        mark.touch(exist_ok=False)
    except FileExistsError:
        return os.getpid()
    os.kill(os.getpid(), signal.SIGKILL)
    return 0


def fail() -> None:
    raise ResultFileError("a file of results is damaged")


def test_tasks_come_back_with_one_blas_thread(cluster: Any, tmp_path: Path) -> None:
    with cluster_workers(cluster.scheduler_address, tmp_path, MEMORY, silent) as executor:
        powers = [executor.submit(pow, 2, exponent) for exponent in range(8)]
        assert sorted(one.result() for one in as_completed(powers)) == [2**k for k in range(8)]
        counts = executor.submit(blas_threads).result()
    assert counts
    assert set(counts) == {1}
    assert list(tmp_path.iterdir()) == []


def test_a_task_whose_worker_is_killed_is_done_by_another(cluster: Any, tmp_path: Path) -> None:
    with Engine(1, cluster.scheduler_address).executor(tmp_path, MEMORY, silent, print) as executor:
        done = executor.submit(die_once, tmp_path / "killed")
        assert done.result(60) > 0
    assert (tmp_path / "killed").exists()


def test_an_error_of_a_task_is_its_own(cluster: Any, tmp_path: Path) -> None:
    with (
        pytest.raises(ResultFileError, match=r"^a file of results is damaged$"),
        cluster_workers(cluster.scheduler_address, tmp_path, MEMORY, silent) as executor,
    ):
        executor.submit(fail).result()


def test_workers_with_little_memory_are_refused_by_name(cluster: Any, tmp_path: Path) -> None:
    name = next(iter(cluster.scheduler_info["workers"]))
    wanted = f"worker {name} may use 1 GB, and a task takes 4; .*--memory-limit 4.0GB"
    with (
        pytest.raises(ResultFileError, match=wanted),
        cluster_workers(cluster.scheduler_address, tmp_path, 4e9, silent),
    ):
        pass


@pytest.mark.parametrize(
    ("address", "said"),
    [
        ("nowhere", "nowhere is no address; allowed: tcp://HOST:PORT"),
        ("tcp://127.0.0.1:99999", "is no address"),
        ("a b:1", "is no address"),
        ("missing.json", "there is no such file; it is made by: dask scheduler --scheduler-file missing.json"),
        ("tcp://127.0.0.1:9", "no scheduler answers there"),
    ],
)
def test_a_cluster_that_is_not_there_is_one_sentence(
    address: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.terminal.cluster.FIRST_CONTACT", 0.5)
    with pytest.raises(ResultFileError, match=said) as refused, cluster_workers(address, tmp_path, 1.0, silent):
        pass
    assert "\n" not in str(refused.value)


def test_a_damaged_scheduler_file_is_one_sentence(tmp_path: Path) -> None:
    file = tmp_path / "scheduler.json"
    file.write_text('{"address": ')
    with (
        pytest.raises(ResultFileError, match="it holds no address of a scheduler"),
        cluster_workers(str(file), tmp_path, 1.0, silent),
    ):
        pass


def test_without_the_extra_its_name_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with (
        pytest.raises(ResultFileError, match=r"pip install 'flexura\[cluster\]'"),
        cluster_workers("tcp://127.0.0.1:9", tmp_path, 1.0, silent),
    ):
        pass


def test_other_code_and_other_libraries_are_told_apart() -> None:
    ours = running()
    assert unlike(ours, dict(ours)) == ""
    assert unlike(ours, ours | {"numpy": "1.0"}) == f"numpy 1.0 (here {ours['numpy']})"
    assert "code none" in unlike(ours, {name: one for name, one in ours.items() if name != "code"})


class StandIn:
    """A client whose workers say of themselves what a test wants."""

    def __init__(self, threads: int, sees: Callable[[Path], bool]) -> None:
        self.threads = threads
        self.sees = sees

    def scheduler_info(self, n_workers: int) -> dict[str, Any]:
        return {"workers": {"tcp://far:1": {"nthreads": self.threads, "memory_limit": 0}}}

    def run(self, state: Any, token: Path, on_error: str) -> dict[str, Any]:
        assert token.is_file()
        return {"tcp://far:1": (running(), self.sees(token))}


@pytest.mark.parametrize(
    ("threads", "sees", "said"),
    [
        (4, True, "worker tcp://far:1 has 4 threads, and one task at a time is safe"),
        (1, False, "worker tcp://far:1 does not see .*; name a folder with --out that all machines share"),
    ],
)
def test_threads_and_folders_that_are_not_shared_are_refused(
    threads: int, sees: bool, said: str, tmp_path: Path
) -> None:
    from app.terminal.cluster import _refused

    (told,) = _refused(StandIn(threads, lambda _: sees), "tcp://here:1", tmp_path, 1e9)
    assert __import__("re").match(said, told)
    assert list(tmp_path.iterdir()) == []
    assert _refused(StandIn(1, Path.is_file), "tcp://here:1", tmp_path, 1e9) == []


def test_a_worker_with_other_code_refuses_the_task(cluster: Any, tmp_path: Path) -> None:
    """As one that joins after the check."""
    with cluster_workers(cluster.scheduler_address, tmp_path, MEMORY, silent) as executor:
        dask = executor._dask
        task = dask.submit(on_worker, running() | {"code": "f" * 64}, pow, 2, 3)
        with pytest.raises(RuntimeError, match=r"tcp://.* runs other code: code "):
            task.result()


@pytest.mark.slow
def test_a_worker_with_other_code_is_refused_by_name(tmp_path: Path) -> None:
    """A copy of the checkout in which one line is another, with the same libraries."""
    other = tmp_path / "other"
    for package in PACKAGES_OF_OURS:
        shutil.copytree(ROOT / package, other / package, ignore=shutil.ignore_patterns("__pycache__"))
    with (other / "analysis" / "material.py").open("a") as file:
        file.write("\nLARGEST_LOSS_FACTOR = 11.0\n")
    where = tmp_path / "scheduler.json"
    scheduler = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--port", "0", "--no-dashboard"]
    worker = [sys.executable, "-m", "distributed.cli.dask_worker", "--nthreads", "1", "--no-dashboard"]
    surroundings = os.environ | {"PYTHONPATH": str(other)}
    quiet: dict[str, Any] = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    with subprocess.Popen([*scheduler, "--scheduler-file", str(where)], **quiet) as first:
        try:
            while not where.exists():
                time.sleep(0.1)
            with subprocess.Popen(
                [*worker, "--no-nanny", "--scheduler-file", str(where)], env=surroundings, cwd=other, **quiet
            ) as second:
                try:
                    with (
                        pytest.raises(ResultFileError, match=r"worker tcp://.* runs other code: code \w{12}"),
                        cluster_workers(str(where), tmp_path, MEMORY, silent),
                    ):
                        pass
                finally:
                    second.terminate()
        finally:
            first.terminate()


def test_a_cluster_that_goes_away_is_one_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.terminal.cluster.FIRST_CONTACT", 2.0)
    made = distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, memory_limit="1GB", dashboard_address=":0", silence_logs=50
    )

    def lose() -> None:
        with cluster_workers(made.scheduler_address, tmp_path, MEMORY, silent) as executor:
            waiting = [executor.submit(time.sleep, 60.0) for _ in range(2)]
            made.close()
            for one in as_completed(waiting):
                one.result()

    with pytest.raises(ResultFileError, match="it went away"):
        lose()
