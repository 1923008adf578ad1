"""The oven is watched whatever its user does: files that hang, a pause without end, a program stuck."""

import threading
import time
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import pytest

from drivers.clock import SystemClock
from drivers.ovens.error import Fault, OvenError
from drivers.ovens.settings import open_oven
from drivers.ovens.simulated.controller import MemoryTransport
from drivers.rig import session, station
from drivers.rig.end_requests import RigStopped
from drivers.rig.session import bring_to_rest
from drivers.watchdog import supervision
from drivers.watchdog.guard import RestRule, State
from drivers.watchdog.supervision import SupervisedOven

World = Any


def blocked(world: World, method: str, seconds: float) -> None:
    """Let one call to the store hang for so long, as on a network share, once the oven ramps."""
    inner, pending = getattr(world.store, method), [seconds]

    def hangs(*values: Any) -> Any:
        if pending and world.parts.body.regulating:
            world.parts.clock.sleep(pending.pop())
        return inner(*values)

    setattr(world.store, method, hangs)


@pytest.mark.parametrize("method", ["log", "keep"])
def test_a_folder_that_hangs_does_not_stop_the_polling(world_of: Callable[..., World], method: str) -> None:
    world = world_of(limits={"lost_after": 120.0})
    times = world.request_times()
    blocked(world, method, 60.0)
    world.run()
    assert max(b - a for a, b in pairwise(times)) < 10.0
    assert world.at_rest()


def test_a_folder_that_hangs_for_too_long_ends_the_campaign_while_it_hangs(world_of: Callable[..., World]) -> None:
    world = world_of(limits={"lost_after": 120.0})
    seen: list[bool] = []
    world.at(200.0, lambda: seen.append(world.parts.body.regulating))  # in the middle of it
    blocked(world, "log", 600.0)
    with pytest.raises(RigStopped, match="stood still for"):
        world.run()
    assert seen == [False]
    assert world.at_rest()


def test_too_hot_while_nobody_looks(world_of: Callable[..., World]) -> None:
    world = world_of(limits={"hottest": 30.0, "lost_after": 3600.0})
    blocked(world, "log", 900.0)
    world.at(20.0, lambda: world.parts.body.go(48.0, 60.0))  # somebody at the panel
    seen: list[bool] = []
    world.at(600.0, lambda: seen.append(world.parts.body.regulating))
    with pytest.raises(RigStopped, match="is outside limits"):
        world.run()
    assert world.at_rest()


def test_a_pause_has_an_end(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(station, "LONGEST_PAUSE", 300.0)
    with pytest.raises(RigStopped, match="paused for"):
        world.run(paused=lambda: True)
    assert world.at_rest()


class Thermostat:
    """An oven that counts, and says what it is told to."""

    limits = None
    poll_within = 30.0

    def __init__(self, air: list[float | OvenError]) -> None:
        self.air, self.said = list(air), []
        self.told = threading.Event()

    def temperature(self) -> float:
        found = self.air.pop(0) if len(self.air) > 1 else self.air[0]
        self.said.append("temperature")
        if isinstance(found, OvenError):
            raise found
        return found

    def ramp_to(self, target: float, rate: float) -> None:
        self.said.append("ramp")

    def close(self) -> None:
        self.said.append("close")

    def safe(self) -> None:
        self.said.append("safe")
        self.told.set()


def watched(world: World, thermostat: Any, clock: Any = None, check: Callable[[], None] = lambda: None) -> Any:
    oven = SupervisedOven(thermostat, world.protocol.limits, clock or world.parts.clock, check)
    oven.begin()
    return oven


def test_one_glitch_beyond_the_limits_is_none(world: World) -> None:
    thermostat = Thermostat([20.0, 99.0, 20.0])
    oven = watched(world, thermostat)
    world.parts.clock.sleep(50.0)
    oven.check()
    assert "safe" not in thermostat.said


@pytest.mark.parametrize(
    ("air", "why"),
    [
        (99.0, "outside limits"),
        (OvenError(Fault.ALARM, "a broken sensor", "look"), "broken sensor"),
        (OvenError(Fault.SILENT, "nothing", "look"), "no temperature from the oven"),
        (float("nan"), "no temperature from the oven"),
    ],
)
def test_trouble_brings_it_to_rest_once_and_for_all(world: World, air: Any, why: str) -> None:
    thermostat = Thermostat([air])
    oven = watched(world, thermostat)
    for _ in range(100):
        world.parts.clock.sleep(1.0)
        oven._user = world.parts.clock.now()
    assert thermostat.said.count("safe") == 1
    with pytest.raises(RigStopped, match=why):
        oven.ramp_to(40.0, 1.0)
    assert "ramp" not in thermostat.said


def test_a_real_thread_goes_on_while_its_user_is_stuck(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(supervision, "PERIOD", 0.01)
    monkeypatch.setattr(supervision, "QUIET", 0.0)
    thermostat = Thermostat([99.0])
    oven = watched(world, thermostat, SystemClock())
    assert thermostat.told.wait(60.0)  # this thread does nothing else meanwhile
    oven.end()


def test_a_request_to_end_is_heard_while_its_user_is_stuck(world: World) -> None:
    def asked_to_end() -> None:
        raise KeyboardInterrupt

    thermostat = Thermostat([20.0])
    watched(world, thermostat, check=asked_to_end)
    world.parts.clock.sleep(2.0)
    assert thermostat.said == ["safe"]


def test_a_line_that_hangs_does_not_keep_the_drive_from_its_rest(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The question of another thread never comes back: the oven is opened anew to be told to rest."""
    monkeypatch.setattr(supervision, "HANGS", 0.01)
    over, waiting = threading.Event(), threading.Event()
    thermostat = Thermostat([20.0])

    def for_ever() -> float:
        waiting.set()
        over.wait(60.0)
        return 20.0

    thermostat.temperature = for_ever  # type: ignore[method-assign]
    oven = watched(world, thermostat)
    thread = threading.Thread(target=oven.temperature)
    thread.start()
    assert waiting.wait(60.0)
    world.parts.server.chassis.lines["cDAQ1Mod2/ao0"].hold(2.0, world.parts.clock.now())
    told = bring_to_rest(world.rig, oven)
    over.set()
    thread.join(60.0)
    assert told == ()
    assert not world.parts.body.regulating
    assert world.parts.server.output_voltage() == 0.0


@pytest.mark.parametrize(("lost_after", "poll_interval"), [(5.0, 3.0), (5.0, 10.0), (5.0, 40.0)])
def test_an_oven_asked_seldom_is_not_lost(
    world_of: Callable[..., World], lost_after: float, poll_interval: float
) -> None:
    """How long it has not answered counts from the first question without an answer, not from the last answer."""
    world = world_of(
        programme={"poll_interval": poll_interval, "ramp_rate": 0.3, "tolerance": 0.5},
        limits={"lost_after": lost_after},
    )
    assert world.run().finished > 0
    assert world.at_rest()
    assert world.store.events_of("trouble") == []


def test_an_oven_that_is_welded_on_is_not_at_rest(world: World) -> None:
    body = world.parts.body
    rest = body._rest

    def welded() -> None:
        rest()
        body._power = 3000.0

    body._rest = welded
    world.run()
    assert "its air went from" in world.unsafe[0]
    assert "pull its mains plug" in world.unsafe[0]


def test_somebody_else_at_the_controller_ends_the_campaign_and_is_told(world: World) -> None:
    """A second computer, or a hand at the panel, lowers the set-point in the middle of the ramp."""
    begun: list[float] = []

    def lowered() -> None:
        begun.append(world.parts.clock.now())
        line = MemoryTransport(world.disturbed, world.parts.clock)
        open_oven(world.rig_settings, world.parts.clock, line).ramp_to(15.0, 1.0)

    world.at(90.0, lowered)
    with pytest.raises(RigStopped, match=r"somebody else commands the oven: its set-point is 15 °C, and .* was"):
        world.run()
    assert world.at_rest()
    (left,) = [event for event in world.store.events_of("oven") if event["command"] == "safe"]
    assert left["time"] - begun[0] < 10.0  # the next reading
    assert world.unsafe == ()


def test_one_wrong_answer_about_the_set_point_ends_nothing(world: World) -> None:
    class Once(Thermostat):
        def changed(self) -> str:
            self.said.append("changed")
            return "its set-point is 99 °C" if self.said.count("changed") == 1 else ""

    thermostat = Once([20.0])
    oven = watched(world, thermostat)
    world.parts.clock.sleep(60.0)
    oven.check()
    assert thermostat.said.count("changed") > 2
    thermostat.changed = lambda: "its set-point is 99 °C"  # type: ignore[method-assign]
    world.parts.clock.sleep(60.0)
    with pytest.raises(RigStopped, match="somebody else commands the oven: its set-point is 99 °C"):
        oven.check()
    assert "safe" in thermostat.said


def test_its_state_is_known_to_whoever_asks_until_it_is_at_rest(world_of: Callable[..., World]) -> None:
    """It is told to rest at 60 °C, and cools by 3 K a minute."""
    world = world_of(limits={"hottest": 70.0})
    clock = world.parts.clock

    class Cooling(Thermostat):
        def temperature(self) -> float:
            super().temperature()
            return 60.0 if "safe" not in self.said else 60.0 - 0.05 * (clock.now() - off[0])

        def safe(self) -> None:
            super().safe()
            off.append(clock.now())

    off: list[float] = []
    oven = SupervisedOven(Cooling([0.0]), world.protocol.limits, clock, lambda: None, RestRule(22.0))
    oven.begin()
    clock.sleep(30.0)
    assert oven.state is State.WATCHING
    oven.safe()
    assert oven.state is State.COOLING
    clock.sleep(60.0)
    assert oven.state is State.AT_REST
    with pytest.raises(RigStopped, match="the oven is at rest: it takes no command"):
        oven.ramp_to(40.0, 1.0)


def test_a_command_that_expires_is_renewed_where_the_oven_has_such(world: World) -> None:
    """By the supervision at every look, and by a simulated rig that restores its state; other ovens have none."""

    class Forgetful(Thermostat):
        def renew(self) -> None:
            self.said.append("renew")

    plain, forgetful = Thermostat([20.0]), Forgetful([20.0])
    for thermostat in (plain, forgetful):
        oven = watched(world, thermostat)
        oven.renew()
        oven.end()
    assert forgetful.said == ["renew"]
    assert plain.said == []
    oven = watched(world, forgetful)
    world.parts.clock.sleep(5.5)
    assert forgetful.said.count("renew") == 1 + 5


def test_who_commands_is_asked_with_every_reading_a_second_apart(world: World) -> None:
    class Asked(Thermostat):
        def changed(self) -> str:
            self.said.append("changed")
            return ""

    thermostat = Asked([20.0])
    oven = watched(world, thermostat)
    for _ in range(5):
        oven.temperature()
        oven.temperature()  # at once: not asked again
        world.parts.clock.sleep(1.0)
    assert thermostat.said == ["changed", "temperature", "temperature"] * 5


def test_people_are_told_of_a_line_that_hangs_once_the_campaign_is_to_end(world: World) -> None:
    """A question is on its way for 50 s, the request to end comes after 10; 20 s count as hung."""
    clock, told = world.parts.clock, []
    begun = clock.now()

    class Slow(Thermostat):
        def temperature(self) -> float:
            clock.sleep(50.0)
            return super().temperature()

    def asked_to_end() -> None:
        if clock.now() > begun + 10.0:
            raise KeyboardInterrupt

    def tell(what: str) -> None:
        told.append((clock.now() - begun, what))

    oven = SupervisedOven(Slow([20.0]), world.protocol.limits, clock, asked_to_end, tell=tell)
    oven.begin()
    oven.temperature()
    ((after, what),) = told
    assert after == pytest.approx(supervision.HANGS, abs=1.5)
    assert "NOT AT REST: the oven: its line is blocked by an earlier request" in what


def test_a_disk_that_hangs_after_the_rig_was_left_is_told_by_another_thread(
    world: World, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """The log's last line, the index, the closing words: of eight hangs there seven said nothing."""
    left = session.Session(world.rig, world.protocol.limits)
    left.unsafe = ("the oven: it regulates",)
    with left.told_if_it_hangs():
        pass  # at once, as always
    assert not caplog.messages
    monkeypatch.setattr(session, "WRITTEN_WITHIN", 0.05)
    with left.told_if_it_hangs():
        time.sleep(0.5)
    (said,) = caplog.messages
    assert "has stood still since it left the rig" in said
    assert "NOT AT REST: the oven: it regulates" in said
