"""The oven comes to rest, or people are told, whatever happens to the campaign's process or to the watchdog's."""

import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="signals and /proc as Linux has them")


def slow(value: Any) -> Any:
    """Leave a case to the slow tests."""
    return pytest.param(value, marks=pytest.mark.slow)


Oven = Any
Campaign = Any
ROOT = Path(__file__).resolve().parents[3]
PROMISE = 15.0
"""Seconds within which the oven is switched off where a watchdog or a campaign lives."""


@pytest.mark.slow
def test_a_campaign_that_ends_leaves_the_oven_seen_cooling_and_no_process(
    oven: Oven, campaign_on: Callable[..., Campaign]
) -> None:
    campaign = campaign_on(oven, "end")
    left = campaign.left(60.0)
    assert left == {"ended": "the end", "unsafe": [], "logged": 1}
    assert not oven.state()["regulating"]
    assert campaign.watchdog_ended(10.0)
    assert campaign.log == ""


@pytest.mark.parametrize("number", [signal.SIGKILL, slow(signal.SIGSTOP), slow(signal.SIGSEGV)])
def test_a_campaign_that_is_killed_or_stopped(
    oven: Oven, campaign_on: Callable[..., Campaign], number: int
) -> None:
    campaign = campaign_on(oven)
    campaign.kill(number=number)
    oven.off(PROMISE)
    if number != signal.SIGSTOP:
        assert campaign.watchdog_ended(30.0)
        assert "has ended without bringing the oven to rest" in campaign.log
        assert campaign.log.rstrip().endswith("the oven is at rest")
        return
    campaign.kill(number=signal.SIGCONT)
    left = campaign.left(60.0)
    assert "has been stopped (SIGSTOP, Ctrl-Z)" in left["ended"]
    assert left["unsafe"] == []


@pytest.mark.parametrize(
    "number",
    [signal.SIGQUIT, *map(slow, (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1, signal.SIGXCPU, signal.SIGALRM))],
)
def test_a_signal_that_would_end_the_process_at_once(
    oven: Oven, campaign_on: Callable[..., Campaign], number: int
) -> None:
    campaign = campaign_on(oven)
    campaign.kill(number=number)
    oven.off(PROMISE)
    left = campaign.left(60.0)
    assert signal.Signals(number).name in left["ended"]
    assert left["unsafe"] == []


@pytest.mark.parametrize("seconds", [10, slow(45)])
def test_the_oven_is_asked_while_a_call_holds_the_interpreter(
    oven: Oven, campaign_on: Callable[..., Campaign], seconds: int
) -> None:
    campaign = campaign_on(oven, f"hang{seconds}")
    time.sleep(1.0)
    oven.state("reset")
    time.sleep(seconds - 2.0)
    state = oven.state()
    assert state["regulating"]
    assert state["longest"] < 10.0
    campaign.kill(number=signal.SIGTERM)  # Python's own handler cannot run now
    oven.off(PROMISE)
    left = campaign.left(60.0)
    assert "SIGTERM" in left["ended"]
    assert left["unsafe"] == []


@pytest.mark.slow
@pytest.mark.parametrize("deed", ["hang600", "file"])
def test_a_call_that_never_comes_back_ends_the_campaign(
    oven: Oven, campaign_on: Callable[..., Campaign], deed: str
) -> None:
    campaign = campaign_on(oven, deed)
    assert oven.off(90.0) > 40.0  # a minute is allowed
    assert oven.state()["longest"] < 10.0
    time.sleep(20.0)
    assert "has stood still for" in campaign.log
    assert "does not answer" in campaign.log


@pytest.mark.slow
def test_a_campaign_that_hangs_after_it_left_the_rig_says_so(
    oven: Oven, campaign_on: Callable[..., Campaign], capfd: pytest.CaptureFixture[str]
) -> None:
    campaign_on(oven, "log")
    oven.off(PROMISE)
    time.sleep(35.0)
    said = capfd.readouterr().err
    assert "has stood still since it left the rig" in said
    assert "the rig: it is at rest" in said


@pytest.mark.parametrize("deed", ["crash", slow("memory")])
def test_a_campaign_that_crashes_or_has_no_memory_left(
    oven: Oven, campaign_on: Callable[..., Campaign], deed: str
) -> None:
    campaign = campaign_on(oven, deed)
    oven.off(PROMISE)
    assert campaign.watchdog_ended(40.0) or campaign.left(40.0)["unsafe"] == []


@pytest.mark.parametrize("number", [signal.SIGKILL, slow(signal.SIGSTOP)])
def test_a_watchdog_that_is_killed_or_stopped(
    oven: Oven, campaign_on: Callable[..., Campaign], number: int
) -> None:
    campaign = campaign_on(oven)
    campaign.kill(watchdog=True, number=number)
    oven.off(PROMISE)
    left = campaign.left(60.0)
    assert "the watchdog's process has" in left["ended"]
    assert left["unsafe"] == []


@pytest.mark.slow
def test_a_watchdog_ignores_what_would_end_it(oven: Oven, campaign_on: Callable[..., Campaign]) -> None:
    campaign = campaign_on(oven)
    for number in (
        signal.SIGINT,
        signal.SIGHUP,
        signal.SIGQUIT,
        signal.SIGUSR1,
        signal.SIGPWR,
        signal.SIGRTMIN + 3,
    ):
        campaign.kill(watchdog=True, number=number)
    time.sleep(3.0)
    assert oven.state()["regulating"]
    assert not campaign.watchdog_ended(1.0)
    campaign.kill(number=signal.SIGTERM)
    assert campaign.left(60.0)["unsafe"] == []


@pytest.mark.slow
def test_a_watchdog_asked_to_end_ends_the_campaign(oven: Oven, campaign_on: Callable[..., Campaign]) -> None:
    """A computer that shuts down sends SIGTERM to every process."""
    campaign = campaign_on(oven)
    campaign.kill(watchdog=True, number=signal.SIGTERM)
    oven.off(PROMISE)
    assert "the watchdog was asked to end" in campaign.left(60.0)["ended"]


@pytest.mark.slow
def test_a_heater_that_is_welded_on_is_told_again_and_again(
    oven_of: Callable[..., Oven], campaign_on: Callable[..., Campaign]
) -> None:
    oven = oven_of("welded")
    campaign = campaign_on(oven)
    campaign.kill(number=signal.SIGTERM)
    left = campaign.left(90.0)
    assert not oven.state()["regulating"]  # it reads back as off
    assert "its air went from" in left["unsafe"][0]
    assert "pull its mains plug" in left["unsafe"][0]
    assert not campaign.watchdog_ended(15.0)  # it looks after the oven, and says so
    assert "NOT AT REST: the oven: it reads back as switched off, but its air went from" in campaign.log


@pytest.mark.slow
def test_random_moments(
    oven_of: Callable[..., Oven], campaign_on: Callable[..., Campaign], record_property: Callable[..., None]
) -> None:
    """Campaign, watchdog or both; killed, stopped or signalled: none stays hot and silent."""
    rng = random.Random(43)  # noqa: S311 (moments, not secrets)
    count = int(os.environ.get("WATCHDOG_KILLS", "60"))
    lone = (signal.SIGKILL, signal.SIGSTOP, signal.SIGQUIT, signal.SIGXCPU, signal.SIGTERM)
    worst = 0.0
    for number in range(count):
        oven = oven_of()
        campaign = campaign_on(oven)
        time.sleep(rng.uniform(0.0, 3.0))
        whom = number % 3
        if whom == 0:
            campaign.kill(number=rng.choice(lone))
        elif whom == 1:
            campaign.kill(watchdog=True, number=rng.choice((signal.SIGKILL, signal.SIGSTOP)))
        else:  # one after the other: the second path is under way, or just done
            campaign.kill(number=rng.choice((signal.SIGSTOP, signal.SIGQUIT)))
            time.sleep(rng.uniform(0.0, 2.0))
            campaign.kill(watchdog=True, number=signal.SIGTERM)
        worst = max(worst, oven.off(PROMISE))
        campaign.kill(number=signal.SIGKILL)
        oven.end()
    record_property("slowest at rest after, s", round(worst, 1))


def test_the_watchdog_imports_nothing_that_may_crash_or_fill_the_memory() -> None:
    code = (
        "import sys, drivers.watchdog.process\n"
        "from drivers.ovens.settings import OVENS\n"
        "for name in OVENS.all(): OVENS.find(name)\n"
        "heavy = {'numpy', 'scipy', 'h5py', 'grpc', 'nidaqmx', 'PySide6', 'torch', 'rich'}\n"
        "print(sorted(heavy & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    assert done.stdout == "[]\n"
