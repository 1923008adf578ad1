import signal
import threading
from collections.abc import Iterator

import pytest

from drivers.interruptions import held_back


@pytest.fixture(autouse=True)
def handlers_are_given_back() -> Iterator[None]:
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    yield
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)] == before


def test_ctrl_c_waits_for_the_end_and_is_not_lost() -> None:
    steps = []

    def pressed_twice() -> None:
        with held_back():
            signal.raise_signal(signal.SIGINT)
            steps.append("after the first")
            signal.raise_signal(signal.SIGINT)
            steps.append("after the second")

    with pytest.raises(KeyboardInterrupt):
        pressed_twice()
    assert steps == ["after the first", "after the second"]


def test_ctrl_c_is_let_through_where_that_is_safe() -> None:
    steps = []
    with held_back() as let_through:
        signal.raise_signal(signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            let_through()
        let_through()
        steps.append("heard once only")
    assert steps


def test_request_to_end_ends_the_program_by_an_exception() -> None:
    with pytest.raises(SystemExit) as caught, held_back():
        signal.raise_signal(signal.SIGTERM)
    assert caught.value.code == 128 + signal.SIGTERM


def test_handler_that_only_takes_note_does_not_stop_anything() -> None:
    noted = []
    ordinary = signal.signal(signal.SIGTERM, lambda number, _: noted.append(number))
    try:
        with held_back() as let_through:
            signal.raise_signal(signal.SIGTERM)
            assert noted == []
            let_through()
            assert noted == [signal.SIGTERM]
    finally:
        signal.signal(signal.SIGTERM, ordinary)


def test_another_thread_is_left_alone() -> None:
    before = signal.getsignal(signal.SIGINT)
    seen = []

    def work() -> None:
        with held_back() as let_through:
            seen.append(signal.getsignal(signal.SIGINT))
            let_through()

    worker = threading.Thread(target=work)
    worker.start()
    worker.join()
    assert seen == [before]


def test_first_error_is_kept_as_the_reason() -> None:

    def pressed_then_failed() -> None:
        with held_back():
            signal.raise_signal(signal.SIGINT)
            raise OSError("card gone")

    with pytest.raises(KeyboardInterrupt) as caught:
        pressed_then_failed()
    assert isinstance(caught.value.__context__, OSError)
