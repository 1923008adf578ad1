"""A page whose figures others have drawn is the page drawn here, byte for byte."""

from collections.abc import Callable
from concurrent.futures import Executor, Future
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any

import pytest

from app.report.written import DrawnParts, write_report
from tests.app.conftest import TinyCampaign

Run = Callable[..., tuple[int, str, str]]


class AtOnce(Executor):
    """Does each task when it is given, and counts them; or breaks, as when a worker is killed."""

    def __init__(self, *, breaks: bool = False) -> None:
        self.breaks = breaks
        self.count = 0

    def submit(self, task: Callable[..., Any], /, *given: Any, **options: Any) -> Future[Any]:
        self.count += 1
        future: Future[Any] = Future()
        if self.breaks:
            future.set_exception(BrokenProcessPool("killed"))
        else:
            future.set_result(task(*given, **options))
        return future


def silent(_stage: str, _share: float) -> None:
    pass


@pytest.fixture
def identified(tiny: TinyCampaign, tmp_path: Path, run_flexura: Run) -> Path:
    folder = tiny.write(tmp_path / "tiny")
    assert run_flexura("identify", folder, "--method", "peak-picking", "--quiet")[0] in (0, 1)
    return tmp_path / "tiny-run"


@pytest.mark.parametrize("breaks", [False, True])
def test_who_drew_a_figure_cannot_be_seen(identified: Path, breaks: bool) -> None:
    write_report(identified, identified, silent, pictures=True)
    alone = {path.name: path.read_bytes() for path in identified.iterdir() if path.suffix in (".html", ".png")}
    assert len(alone) > 3
    workers = AtOnce(breaks=breaks)
    written = write_report(identified, identified, silent, pictures=True, executor=workers)
    assert workers.count == 2
    assert {path.name: path.read_bytes() for path in identified.iterdir() if path.name in alone} == alone
    assert written.size == len(alone["report.html"])
    assert {f"{name}.png" for name in written.figures} == set(alone) - {"report.html"}


def test_a_result_that_cannot_be_read_is_told_by_the_process_that_writes_the_page(identified: Path) -> None:
    from app.files.bad_file import ResultFileError

    path = identified / "modes.h5"
    path.write_bytes(path.read_bytes()[:3000])
    with pytest.raises(ResultFileError, match=r"modes\.h5"):
        write_report(identified, identified, silent, executor=AtOnce())


def test_nothing_is_begun_twice_or_without_a_result(identified: Path) -> None:
    workers = AtOnce()
    parts = DrawnParts(workers)
    for name in ("frf.h5", "frf.h5", "laws.h5"):
        parts.begin(identified, name)
    assert workers.count == 1
