"""The computer dies at any moment: an oven whose controller has a program, or a timer, comes to rest by itself."""

import math
import random
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from drivers.ovens.expiry import HARMLESS
from drivers.rig.end_requests import RigStopped
from drivers.rig.session import rest_oven

World = Any
Kill = Callable[[World, Callable[[Callable[[], None]], None]], None]

REST_AFTER = 600.0
LEFT_ALONE = {
    "eurotherm-2400": {"rest_after": REST_AFTER, "program": 2},
    "watlow-f4t": {"rest_after": REST_AFTER, "program": 5},
    "espec-p300": {"rest_after": REST_AFTER},
}
SOAK = {"soak_before": 800.0, "approach_rate": 2.0}
"""Long enough for two renewals."""


@pytest.fixture(params=list(LEFT_ALONE))
def abandoned(request: pytest.FixtureRequest, world_of: Callable[..., World]) -> Callable[[], World]:
    """Return a function that sets up a campaign with an oven that ends by itself, of each kind in turn."""

    def make() -> World:
        world = world_of(request.param, LEFT_ALONE[request.param], programme=SOAK)
        if request.param == "espec-p300":
            world.parts.controller._controller._patience = math.inf  # one of those that nobody needs to ask
        return world

    return make


def at_exchange(world: World, number: int, die: Callable[[], None]) -> None:
    """Die when the controller has received so many requests, before the answer comes."""
    receive, left = world.disturbed.receive, [number]

    def deadly(data: bytes) -> Any:
        answers = receive(data)
        left[0] -= 1
        if left[0] == 0:
            die()
        return answers

    world.disturbed.receive = deadly


def seconds_to_rest(world: World) -> float:
    """Let an abandoned oven be, and return how much later it is at rest than its program lasts."""
    body, clock = world.parts.body, world.parts.clock
    ramp = 60.0 * abs(body.target - body.working) / body._rate if body.regulating else 0.0
    clock.sleep(math.ceil(ramp) + REST_AFTER)
    late = 0.0
    while body.regulating and late < 3600.0:
        clock.sleep(10.0)
        late += 10.0
    return late


def killed(world: World, killed_by: Kill, arrange: Callable[[Callable[[], None]], None]) -> None:
    """Kill a campaign, and see that its oven comes to rest within ten minutes more than its program lasts."""
    killed_by(world, arrange)
    late = seconds_to_rest(world)
    # between two programs, for a moment, the oven has nothing but a set-point
    harmless = world.parts.body.regulating and abs(world.parts.body.target - HARMLESS) < 1.0
    assert harmless or late <= 600.0


@pytest.mark.parametrize("moment", [3.0, 305.0])
def test_killed_it_comes_to_rest(abandoned: Callable[[], World], killed_by: Kill, moment: float) -> None:
    """On the ramp, and just after the first renewal."""
    world = abandoned()
    killed(world, killed_by, lambda die: world.at(moment, die))


@pytest.mark.slow
def test_killed_twenty_times_at_random_moments_it_comes_to_rest(
    abandoned: Callable[[], World], killed_by: Kill
) -> None:
    """Killed half of the time by the clock, half in the middle of some exchange with the controller."""
    undisturbed = abandoned()
    requests = undisturbed.request_times()
    undisturbed.run()
    began = undisturbed.store.events_of("oven")[0]["time"]
    first = sum(time < began for time in requests)
    rng = random.Random(20)  # noqa: S311 (moments, not secrets)
    for number in range(20):
        world, moment = abandoned(), rng.uniform(began, requests[-1] - 10.0)
        exchange = rng.randint(first, len(requests) - 20)
        if number % 2:
            killed(world, killed_by, lambda die, w=world, e=exchange: at_exchange(w, e, die))
        else:
            killed(world, killed_by, lambda die, w=world, m=moment: w.at(m, die))


def test_ends_as_if_it_had_never_been_killed(
    abandoned: Callable[[], World], killed_at: Callable[[World, float], None]
) -> None:
    undisturbed = abandoned()
    assert undisturbed.run().missing == 0
    assert undisturbed.store.events_of("trouble") == []  # it was renewed, and nothing else noticed it
    moment = undisturbed.store.events_of("sweep begun")[1]["time"] + 0.4
    world = abandoned()
    killed_at(world, moment)
    world.renew()
    if world.kind == "espec-p300":
        world.parts.controller._controller._patience = math.inf
    assert world.run().missing == 0
    assert world.digests() == undisturbed.digests()


def test_without_it_an_abandoned_oven_goes_on(world_of: Callable[..., World], killed_by: Kill) -> None:
    world = world_of("watlow-f4t")
    killed_by(world, lambda die: world.at(60.0, die))
    world.parts.clock.sleep(86_400.0)
    assert world.parts.body.regulating


@pytest.mark.parametrize("kind", list(LEFT_ALONE))
def test_a_controller_without_is_refused_before_anything_moves(world_of: Callable[..., World], kind: str) -> None:
    """The answer to `oven.program` on a controller that has none, and what goes without."""
    world = world_of(kind, LEFT_ALONE[kind])
    controller = world.parts.controller._controller
    if kind == "espec-p300":
        known = controller._command
        controller._command = lambda words: "NA:CMD ERR" if "TIMER" in words else known(words)
    else:
        controller.programmer = controller.profiles = False
    with pytest.raises(RigStopped, match=r"oven\.(program|rest_after)"):
        world.run()
    assert world.at_rest()
    assert max(abs(temperature - 22.0) for temperature in (world.parts.body.air, world.parts.body.plate)) < 0.2


def test_where_a_watchdog_brought_the_oven_to_rest_its_ramp_is_begun_again(
    world_of: Callable[..., World], killed_at: Callable[[World, float], None]
) -> None:
    """The log ends with the ramp of the killed process; no half hour passes until that ramp counts as stalled."""
    undisturbed = world_of("watlow-f4t")
    assert undisturbed.run().missing == 0
    world = world_of("watlow-f4t")
    killed_at(world, undisturbed.store.events_of("sweep begun")[1]["time"] + 0.4)
    assert world.parts.body.regulating
    alone = world.rig
    assert rest_oven(alone.open_oven, alone.clock) is None
    world.parts.clock.sleep(120.0)
    world.rig = replace(alone, supervise=alone.open_supervised)
    assert world.run().missing == 0
    assert world.store.events_of("trouble") == []
    assert set(world.store.kept) == set(undisturbed.store.kept)
    assert world.worst_error() < 0.01
