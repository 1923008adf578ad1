"""However a session ends, the rig is at rest, or it is said what is not: every error, step and way out."""

import os
import signal
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import Any

import pytest

from drivers.ni.cards import Action, DaqError
from drivers.ni.simulated.faults import Faults
from drivers.ovens.error import Fault, OvenError
from drivers.rig.end_requests import EndRequests, RigInterrupted, RigStopped
from drivers.rig.session import bring_to_rest

World = Any


class Oddity(BaseException):
    """No Exception: as some libraries stop their own threads."""


ERRORS: tuple[BaseException, ...] = (
    ValueError("Cannot invoke RPC on closed channel!"),
    RuntimeError("dictionary changed size during iteration"),
    TypeError("unsupported operand"),
    ZeroDivisionError("defect"),
    RecursionError("maximum recursion depth exceeded"),
    MemoryError(),
    StopIteration(),
    OSError(28, "No space left on device"),
    UnicodeDecodeError("ascii", b"\xff", 0, 1, "ordinal not in range"),
    DaqError("the sweep", "Device lost.", -201003, Action.LOST_DEVICE, "look"),
    DaqError("the sweep", "Unknown.", -1, Action.STOP, "look"),
    OvenError(Fault.ALARM, "a broken sensor", "look"),
    OvenError(Fault.PORT, "unplugged", "look"),
    RigStopped("enough", "go on later"),
    RigInterrupted("SIGINT"),
    KeyboardInterrupt(),
    SystemExit(1),
    Oddity("none of ours"),
)

STEPS = (
    "open_oven",
    "open_cards",
    "oven.temperature",
    "oven.ramp_to",
    "oven.hold",
    "oven.close",
    "cards.temperatures",
    "cards.sweep",
    "cards.close",
    "store.log",
    "store.events",
    "store.finished",
    "store.keep",
    "observer",
    "paused",
    "date",
)

LEAVINGS = {
    "nothing else fails": (),
    "the oven is out of reach": ("oven",),
    "the cards are out of reach": ("drive",),
    "neither can be reached": ("oven", "drive"),
    "the log fails as well": (),
    "signals come meanwhile": (),
}
"""What else happens while the rig is brought to rest, and what is to be told as not at rest."""


class Trouble:
    """Raises an error in one step, and makes things worse while the rig is brought to rest."""

    def __init__(self, world: World, step: str, error: BaseException, leaving: str) -> None:
        self.world, self.step, self.error, self.leaving = world, step, error, leaving
        self.calls: Counter[str] = Counter()
        self.struck = False

    def at(self, step: str) -> None:
        self.calls[step] += 1
        if step == self.step and not (self.struck and step in ("open_oven", "open_cards", "cards.close")):
            self.struck = True
            raise self.error
        lost, again = LEAVINGS[self.leaving], self.calls[step] > 1
        if "oven" in lost and (step == "oven.safe" or (step == "open_oven" and again)):
            raise self.error
        if "drive" in lost and (step == "cards.close" or (step == "open_cards" and again)):
            raise self.error
        if not self.calls["oven.safe"]:
            return
        if self.leaving == "signals come meanwhile" and step in ("oven.safe", "cards.close"):
            for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
                os.kill(os.getpid(), number)
        if self.leaving == "the log fails as well" and step == "store.log":
            raise self.error

    def wrapped(self, step: str, action: Callable[..., Any]) -> Callable[..., Any]:
        def trying(*values: Any, **options: Any) -> Any:
            if step == "cards.sweep" == self.step:  # broken off in the middle of a tone
                self.world.parts.server.chassis.lines["cDAQ1Mod2/ao0"].hold(2.0, self.world.parts.clock.now())
            self.at(step)
            return action(*values, **options)

        return trying

    def around(self, part: str, thing: Any, *names: str) -> Any:
        for name in names:
            setattr(thing, name, self.wrapped(f"{part}.{name}", getattr(thing, name)))
        return thing


def ran(world: World, step: str, error: BaseException, leaving: str) -> Trouble:
    """Run a campaign into trouble."""
    trouble = Trouble(world, step, error, leaving)
    rig, asked = world.rig, iter([False] * 2 + [True])
    oven_of, cards_of = trouble.wrapped("open_oven", rig.open_oven), trouble.wrapped("open_cards", rig.open_cards)
    world.rig = replace(
        rig,
        open_oven=lambda: trouble.around("oven", oven_of(), "temperature", "ramp_to", "hold", "safe", "close"),
        open_cards=lambda: trouble.around("cards", cards_of(), "temperatures", "sweep", "close"),
        date=trouble.wrapped("date", rig.date),
    )
    trouble.around("store", world.store, "log", "events", "finished", "keep")
    with EndRequests() as requests, suppress(BaseException):
        world.run(
            requests.check,
            observer=trouble.wrapped("observer", lambda moment: None),
            paused=trouble.wrapped("paused", lambda: next(asked, False)),
        )
    return trouble


def check(world: World, step: str, error: BaseException, leaving: str) -> None:
    trouble = ran(world, step, error, leaving)
    case = f"{error!r} in {step}, {leaving}"
    assert trouble.struck, case
    assert world.unsafe is not None, case
    told = tuple(part for part in ("oven", "drive") if any(f"the {part}" in what for what in world.unsafe))
    unread = step == "oven.temperature"  # an oven that cannot be read cannot be seen to cool
    assert set(told) == {*LEAVINGS[leaving], *(["oven"] if unread else [])}, case
    if "oven" not in LEAVINGS[leaving]:
        assert not world.parts.body.regulating, case
    if "drive" not in told:
        assert world.parts.server.output_voltage() == 0.0, case


@pytest.fixture
def short(world_of: Callable[..., World]) -> Callable[[], World]:
    """Return what makes a campaign of one sweep, soon after it has begun."""
    programme = {"lowest": 22.5, "highest": 22.5, "every": 1.0, "lead": 0.3, "soak_before": 0.0, "watch": "air"}
    settling = {"within": 0.5, "lasting": 0.0}

    def make() -> World:
        world = world_of(programme=programme | {"settling": settling}, limits={"lost_after": 20.0})
        world.parts.wiring.__dict__["thermocouples"] = ()
        return world

    return make


@pytest.mark.parametrize("step", STEPS)
def test_at_rest_or_told_whatever_fails_where(short: Callable[[], World], step: str) -> None:
    """Every error in every step, the ways out in turn: 288 sessions."""
    for number, error in enumerate(ERRORS):
        check(short(), step, error, list(LEAVINGS)[(number + STEPS.index(step)) % len(LEAVINGS)])


@pytest.mark.slow
@pytest.mark.parametrize("leaving", LEAVINGS)
@pytest.mark.parametrize("step", STEPS)
def test_every_error_in_every_step_on_every_way_out(short: Callable[[], World], step: str, leaving: str) -> None:
    for error in ERRORS:
        check(short(), step, error, leaving)


@pytest.mark.parametrize("oven_there", [True, False])
@pytest.mark.parametrize("cards_there", [True, False])
def test_a_rig_left_hot_is_brought_to_rest_without_a_campaign(
    short: Callable[[], World], oven_there: bool, cards_there: bool
) -> None:
    world = short()
    world.rig.open_oven().ramp_to(45.0, 1.0)
    line = world.parts.server.chassis.lines["cDAQ1Mod2/ao0"]
    line.hold(2.0, world.parts.clock.now())

    def absent() -> Any:
        raise OvenError(Fault.PORT, "no such port", "look")

    rig = world.rig if oven_there else replace(world.rig, open_oven=absent)
    unsafe = bring_to_rest(rig if cards_there else replace(rig, open_cards=absent))
    assert world.parts.body.regulating is not oven_there
    assert (world.parts.server.output_voltage() == 0.0) is cards_there
    assert ["oven could not" in told for told in unsafe if "no such port" in told] == (
        [True] * (not oven_there) + [False] * (not cards_there)
    )
    assert "turn the amplifier off" in " ".join(unsafe) or cards_there


def test_an_oven_that_answers_no_more_is_opened_anew(short: Callable[[], World]) -> None:
    """Its adapter was unplugged and is back: the port that was open stays dead, another one is not."""
    world = short()
    oven = world.rig.open_oven()
    oven.ramp_to(45.0, 1.0)
    closed: list[bool] = []

    def dead() -> Any:
        raise OvenError(Fault.PORT, "the port is gone", "look")

    oven.safe, oven.close = dead, lambda: closed.append(True)
    rig = replace(world.rig, open_oven=lambda: world.parts.rig().open_oven() if closed else dead())
    assert bring_to_rest(rig, oven) == ()
    assert not world.parts.body.regulating


def test_an_oven_left_ramping_is_told_to_rest_where_the_chassis_is_gone(short: Callable[[], World]) -> None:
    """As after a power cut: the oven has come back with its ramp, the chassis has not."""
    world = short()
    world.rig.open_oven().ramp_to(45.0, 1.0)
    world.parts.server.inject(Faults(unplugged=(0.0, 1e9)))
    with pytest.raises(RigStopped, match="the rig cannot be opened"):
        world.run()
    assert not world.parts.body.regulating
    assert ["turn the amplifier off" in told for told in world.unsafe] == [True]
    assert world.store.events_of("oven")[-1]["unsafe"] == list(world.unsafe)


def test_an_oven_left_ramping_and_in_trouble_is_told_to_rest_before_the_cards_are_opened(
    short: Callable[[], World],
) -> None:
    world = short()
    world.rig.open_oven().ramp_to(45.0, 1.0)
    world.parts.controller._controller.sensor_broken = True
    with pytest.raises(RigStopped, match=r"the rig cannot be opened.*no valid temperature"):
        world.run()
    assert world.at_rest()


def test_a_campaign_killed_in_its_last_soak_is_complete_and_leaves_the_oven_at_rest(
    world_of: Callable[..., World],
) -> None:
    world = world_of(programme={"soak_after": 600.0})
    finished = world.run()
    world.store.log_lines = [event for event in world.store.log_lines if event.get("command") != "safe"]
    world.rig.open_oven().ramp_to(45.0, 1.0)
    assert world.run() == replace(finished, made_now=0)
    assert world.at_rest()


def test_a_request_to_end_is_heard_in_the_middle_of_a_sweep(world: Any) -> None:
    world.plate.before = lambda: os.kill(os.getpid(), signal.SIGHUP)
    with EndRequests() as requests, pytest.raises(RigInterrupted, match="SIGHUP"):
        world.run(requests.check)
    assert world.plate.sweeps == 1
    assert world.at_rest()
    assert world.unsafe == ()
