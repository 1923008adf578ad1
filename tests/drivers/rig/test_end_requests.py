import os
import signal
import subprocess
import sys

import pytest

from drivers.interruptions import ENDING, signal_name
from drivers.rig.end_requests import EndRequests, RigInterrupted


@pytest.mark.parametrize("number", ENDING)
def test_a_request_raises_nothing_until_it_is_asked_for(number: int) -> None:
    usual = signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL
    signal.signal(number, usual)  # shells start what runs in the background with some ignored
    signal.signal(signal.SIGINT, signal.default_int_handler)
    before = [signal.getsignal(one) for one in ENDING]
    with EndRequests() as requests:
        requests.check()
        signal.raise_signal(number)
        signal.raise_signal(signal.SIGINT)
        assert (requests.arrived, requests.number) == (signal_name(number), number)
        for _ in range(2):  # whoever has caught it once is told again
            with pytest.raises(RigInterrupted, match=signal_name(number)):
                requests.check()
    assert [signal.getsignal(one) for one in ENDING] == before


@pytest.mark.skipif(os.name == "nt", reason="signals as POSIX has them")
def test_what_was_ignored_at_the_start_stays_ignored() -> None:
    """As for a program that nohup has started."""
    code = (
        "import os, signal\n"
        "from drivers.rig.end_requests import EndRequests\n"
        "with EndRequests() as requests:\n"
        "    os.kill(os.getpid(), signal.SIGHUP)\n"
        "    requests.check()\n"
        "    os.kill(os.getpid(), signal.SIGTERM)\n"
        "print(requests.arrived)"
    )
    # a shell ignores it: code of ours in a forked process would run among the remains of gRPC's threads
    command = ["/bin/sh", "-c", """trap '' HUP; exec "$@" """, "sh", sys.executable, "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout == "SIGTERM\n"


@pytest.mark.skipif(os.name == "nt", reason="signals as POSIX has them")
@pytest.mark.parametrize("name", ["SIGTSTP", "SIGTTIN", "SIGTTOU"])
def test_ctrl_z_does_not_stop_a_campaign(name: str, capfd: pytest.CaptureFixture[str]) -> None:
    number = getattr(signal, name)
    before = signal.getsignal(number)
    with EndRequests() as requests:
        signal.raise_signal(number)  # without a handler, the test's own process would stop here
        requests.check()
    assert ("Ctrl-C ends the campaign" in capfd.readouterr().err) == (name == "SIGTSTP")
    assert signal.getsignal(number) == before


def test_a_closed_console_is_waited_for() -> None:
    """What Windows calls, in a thread of its own; it ends the program when that returns."""
    requests = EndRequests()
    with requests:
        assert not requests._console_ends(0)  # Ctrl-C
        requests.check()
    assert requests._console_ends(2)  # returns at once where everything is over
    assert (requests.arrived, requests.number) == ("CTRL_CLOSE_EVENT", 0)
    with pytest.raises(RigInterrupted, match="CTRL_CLOSE_EVENT"):
        requests.check()
