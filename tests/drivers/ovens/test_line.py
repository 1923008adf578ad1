"""Retries, gaps, time-outs and late answers, in virtual time."""

import threading

import pytest

from drivers.clock import VirtualClock
from drivers.ovens.error import Fault, OvenError
from drivers.ovens.line import Line, Timing, up_to
from drivers.ovens.simulated.controller import LineController, MemoryTransport
from tests.drivers.ovens.served import Disturbed, halved, in_pieces, late, silenced

END = up_to(b"\n")


class Counter(LineController):
    """Answers each question with the same in capitals, and counts."""

    def __init__(self):
        super().__init__(b"\n")
        self.asked = []

    def answer(self, command):
        self.asked.append(command)
        return command.upper()


class Setup:
    def __init__(self, **timing):
        self.clock = VirtualClock()
        self.counter = Counter()
        self.far = Disturbed(self.counter)
        self.transport = MemoryTransport(self.far, self.clock)
        self.line = Line(self.transport, self.clock, Timing(**timing))

    def ask(self, question=b"a", *, writes=False):
        def action():
            answer = self.line.exchange(question + b"\n", END)
            if not answer:
                raise OvenError(Fault.SILENT, "nothing", "advice")
            if answer != question.upper() + b"\n":
                raise OvenError(Fault.GARBLED, f"{answer!r}", "advice")
            return answer

        return self.line.attempt(action, writes=writes)


def test_tries_again_and_no_more_often_than_told():
    setup = Setup(retries=2)
    setup.far.disturb(silenced, halved)
    assert setup.ask() == b"A\n"
    assert setup.counter.asked == ["a"] * 3
    setup.far.disturb(silenced, silenced, silenced)
    with pytest.raises(OvenError, match="nothing, 3 attempts") as caught:
        setup.ask()
    assert caught.value.fault is Fault.SILENT
    assert len(setup.counter.asked) == 6


@pytest.mark.parametrize("fault", [Fault.REFUSED, Fault.ALARM, Fault.NOT_TAKEN])
def test_what_repeating_cannot_help_is_not_repeated(fault):
    setup = Setup(retries=5)
    calls = []

    def refused():
        calls.append(1)
        raise OvenError(fault, "no", "advice", "code")

    with pytest.raises(OvenError, match="no") as caught:
        setup.line.attempt(refused)
    assert (len(calls), caught.value.code) == (1, "code")


def test_gaps_after_questions_and_commands():
    setup = Setup(gap_after_read=0.3, gap_after_write=1.0)
    setup.ask()
    assert setup.clock.now() == 0.0
    setup.ask(writes=True)
    assert setup.clock.now() == pytest.approx(0.3)
    setup.ask()
    assert setup.clock.now() == pytest.approx(1.3)
    setup.clock.sleep(5.0)  # time that has passed anyway need not pass again
    setup.ask()
    assert setup.clock.now() == pytest.approx(6.3)


def test_a_late_answer_is_never_taken_for_the_next_one():
    setup = Setup(timeout=0.5, retries=1)
    setup.far.disturb(late(0.7))
    assert setup.ask(b"first") == b"FIRST\n"
    assert setup.ask(b"second") == b"SECOND\n"


def test_answers_that_are_always_late_end_with_the_right_advice():
    setup = Setup(timeout=0.5, retries=1)
    setup.far.always = late(0.7)
    with pytest.raises(OvenError, match=r"later than the time-out of 0\.5 s") as caught:
        setup.ask()
    assert "Raise timeout" in caught.value.advice


def test_an_interrupted_exchange_does_not_answer_the_next():
    setup = Setup(timeout=0.5)

    class Interrupting:
        """The transport, once struck by Ctrl-C between question and answer."""

        struck = False

        def __getattr__(self, name):
            return getattr(setup.transport, name)

        def read(self, wait):
            if not self.struck:
                self.struck = True
                raise KeyboardInterrupt
            return setup.transport.read(wait)

    line = Line(Interrupting(), setup.clock, Timing(timeout=0.5))
    setup.far.always = late(0.1)
    with pytest.raises(KeyboardInterrupt):
        line.attempt(lambda: line.exchange(b"interrupted\n", END))
    assert line.attempt(lambda: line.exchange(b"next\n", END)) == b"NEXT\n"


def test_an_answer_in_pieces_is_one_answer():
    setup = Setup(timeout=1.0, retries=0)
    setup.far.disturb(in_pieces(0.01))
    assert setup.ask(b"a long question") == b"A LONG QUESTION\n"


def test_a_time_out_is_for_the_whole_answer():
    setup = Setup(timeout=1.0, retries=0)
    setup.far.disturb(in_pieces(0.3))
    with pytest.raises(OvenError) as caught:
        setup.ask(b"a long question")
    assert caught.value.fault is Fault.GARBLED


def test_endless_noise_ends():
    clock = VirtualClock()

    class Babbling:
        def write(self, data):
            pass

        def drain(self):
            pass

        def read(self, wait):
            clock.sleep(0.125)
            return b"\xff"

        def close(self):
            pass

    line = Line(Babbling(), clock, Timing(timeout=1.0, retries=1))

    def action():
        answer = line.exchange(b"a\n", END)
        raise OvenError(Fault.GARBLED, f"{len(answer)} bytes", "advice")

    with pytest.raises(OvenError, match="8 bytes, 2 attempts"):
        line.attempt(action)
    assert clock.now() < 30.0


def test_silence_may_end_an_answer():
    setup = Setup(timeout=1.0)
    setup.far.disturb(in_pieces(0.01))
    assert setup.line.exchange(b"no end told\n", lambda _: None, quiet=0.1) == b"NO END TOLD\n"
    assert setup.clock.now() == pytest.approx(0.11 + 0.1)


def test_contact_is_lost_when_every_attempt_has_failed_for_too_long():
    setup = Setup(timeout=1.0, retries=0, lost_after=10.0)
    setup.ask()
    setup.clock.sleep(1000.0)  # nobody asked: that is not a loss
    setup.far.always = silenced
    faults = []
    while Fault.LOST not in faults:
        begun = setup.clock.now()
        with pytest.raises(OvenError) as caught:
            setup.ask()
        faults.append(caught.value.fault)
    assert set(faults[:-1]) == {Fault.SILENT}
    assert 9.0 <= setup.clock.now() - 1000.0 <= 13.0
    assert "Stop the campaign" in caught.value.advice
    setup.far.always = lambda answer: [answer]
    setup.ask()  # found again
    setup.far.always = silenced
    with pytest.raises(OvenError) as caught:
        setup.ask()
    assert caught.value.fault is Fault.SILENT
    assert begun > 0.0


def test_a_cable_pulled_and_plugged_in_again():
    setup = Setup(timeout=0.5, retries=1, lost_after=60.0)
    setup.transport.plugged = False
    with pytest.raises(OvenError, match="unplugged") as caught:
        setup.ask()
    assert caught.value.fault is Fault.PORT
    setup.transport.plugged = True
    assert setup.ask() == b"A\n"


def test_noise_before_a_question_is_thrown_away():
    setup = Setup(retries=0)
    setup.far.disturb(lambda answer: [answer, answer._replace(data=b"nobody asked\n")])
    setup.ask(b"first")
    assert setup.ask(b"second") == b"SECOND\n"


def test_threads_do_not_mix_their_exchanges():
    setup = Setup(timeout=1.0, retries=0)
    wrong = []

    def work(name):
        for i in range(100):
            question = f"{name}{i}".encode()
            with setup.line.reserved():
                if setup.ask(question) != question.upper() + b"\n" or setup.counter.asked[-1] != question.decode():
                    wrong.append(question)

    threads = [threading.Thread(target=work, args=(name,)) for name in "abcd"]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []


@pytest.mark.parametrize(
    "timing",
    [{"timeout": 0.0}, {"retries": -1}, {"timeout": 5.0, "lost_after": 1.0}, {"gap_after_read": -0.1}],
)
def test_timing_that_is_none_is_refused(timing):
    with pytest.raises(ValueError, match="Timing"):
        Timing(**timing)


def test_a_closed_line_stays_closed():
    setup = Setup(retries=0)
    setup.line.close()
    setup.line.close()
    with pytest.raises(OvenError, match="closed"):
        setup.ask()
