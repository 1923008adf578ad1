"""Copies of a process do its work: same results, errors and order; what they are killed by costs time only."""

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ProcessPoolExecutor
from functools import cached_property
from multiprocessing import resource_tracker
from pathlib import Path

import numpy as np
import pytest

from analysis import forked
from analysis.forked import ForkedExecutor

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="copies are made on Linux")


def children():
    """Find processes that this one has begun and not buried."""
    there = {int(one.name) for one in Path("/proc").iterdir() if one.name.isdigit()}
    return {one for one in there - KNOWN if parent_of(one) == os.getpid()}


def parent_of(number):
    try:
        return int(Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[1])
    except OSError:
        return None


KNOWN: set[int] = set()


@pytest.fixture(autouse=True)
def nothing_left():
    resource_tracker.ensure_running()  # Python's own helper process
    KNOWN.update(children())
    yield
    assert not children()


@pytest.mark.parametrize("count", [0, 1, 2, 3, 7])
def test_results_come_in_their_order_from_several_processes(count):
    big = np.arange(300_000.0)  # larger than a pipe holds
    with ForkedExecutor(3) as executor:
        found = list(executor.map(lambda one, two: (one * big, two, os.getpid()), range(count), range(9)))
    for k, (array, second, _) in enumerate(found):
        np.testing.assert_array_equal(array, k * big)
        assert second == k
    assert len({pid for *_, pid in found}) == min(count, 3)


def test_an_error_is_raised_where_it_is_waited_for():
    def work(k):
        if k == 1:
            raise ValueError("outside its box")
        time.sleep(60.0 if k == 2 else 0.0)  # nobody waits for it

    started = time.monotonic()
    with ForkedExecutor(3) as executor, pytest.raises(ValueError, match="outside its box"):
        executor.map(work, range(3))
    assert time.monotonic() - started < 30.0


def test_what_a_killed_copy_did_not_finish_is_done_here():
    here = os.getpid()

    def work(k):
        if os.getpid() != here:
            os.kill(os.getpid(), signal.SIGKILL)
        return k

    with ForkedExecutor(2) as executor:
        assert list(executor.map(work, range(4))) == [0, 1, 2, 3]
        assert executor.processes == 1


def test_a_copy_that_hangs_is_given_up(monkeypatch):
    """A thread that computes holds the lock of what is cached: in a copy it is never released."""
    monkeypatch.setattr(forked, "AT_LEAST", 0.5)
    lock, here = threading.Lock(), os.getpid()

    def work(k):
        if os.getpid() != here:
            lock.acquire()
        return k

    with ForkedExecutor(2) as executor, lock:
        assert list(executor.map(work, range(4))) == [0, 1, 2, 3]
        assert executor.processes == 1


def test_threads_that_compute_side_by_side_make_no_copies():
    """All instances of a class share the lock of `cached_property`; a start grid waited for it for ever."""

    class Slow:
        @cached_property
        def value(self):
            time.sleep(0.002)
            return 1

    def walk(_):
        return [sum(executor.map(lambda _: Slow().value, range(4))) for _ in range(40)]

    with ForkedExecutor(2) as executor:
        walks = [executor.submit(walk, k) for k in range(2)]
        assert [one.result(60.0) for one in walks] == [[4] * 40] * 2


def test_a_copy_makes_no_copies():
    with ForkedExecutor(2) as executor:
        found = list(executor.map(lambda _: set(executor.map(lambda _: os.getpid(), range(3))), range(2)))
    assert len(found[1]) == 1


def test_single_work_shares_memory():
    seen = []
    with ForkedExecutor(2) as executor:
        executor.submit(seen.append, 1).result()
    assert seen == [1]


def test_handlers_of_this_process_do_not_run_in_a_copy(tmp_path):
    told, here = tmp_path / "told", os.getpid()
    before = signal.signal(signal.SIGTERM, lambda *_: told.write_text("handled"))
    try:

        def work(k):
            if os.getpid() != here:
                os.kill(os.getpid(), signal.SIGTERM)
                time.sleep(1.0)
            return k

        with ForkedExecutor(2) as executor:
            assert list(executor.map(work, range(2))) == [0, 1]
    finally:
        signal.signal(signal.SIGTERM, before)
    assert not told.exists()


ALONE = """
import os, time, numpy
from analysis.forked import ForkedExecutor
def work(k):
    if os.getpid() == here:
        print(flush=True)
        time.sleep(60)
    return numpy.zeros(300_000)
here = os.getpid()
with ForkedExecutor(3) as executor:
    executor.map(work, range(3))
"""


def test_copies_end_with_a_process_that_is_killed():
    with subprocess.Popen(
        [sys.executable, "-c", ALONE], stdout=subprocess.PIPE, start_new_session=True
    ) as process:
        assert process.stdout is not None
        process.stdout.readline()
        process.kill()
        process.wait()
        until = time.monotonic() + 20.0
        while alive(process.pid):
            assert time.monotonic() < until, "copies are left"
            time.sleep(0.05)


def alive(session):
    """Whether a process of a session is there."""
    try:
        os.killpg(session, 0)
    except ProcessLookupError:
        return False
    return True


def test_other_threads_go_on():
    stop, ticks = threading.Event(), []

    def tick():
        while not stop.wait(0.001):
            ticks.append(1)

    other = threading.Thread(target=tick)
    other.start()
    with ForkedExecutor(2) as executor:
        for _ in range(20):
            assert list(executor.map(lambda k: k + 1, range(4))) == [1, 2, 3, 4]
    stop.set()
    other.join()
    assert ticks


def processes_there():
    return ForkedExecutor().processes


def test_a_worker_process_leaves_other_processors_to_its_siblings():
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        assert pool.submit(processes_there).result() == 1
