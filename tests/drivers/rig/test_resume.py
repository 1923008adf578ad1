"""Campaigns that were killed, when nothing could be brought to rest, and taken up again."""

from collections.abc import Callable
from dataclasses import replace
from datetime import datetime
from typing import Any

import pytest

from drivers.ni.simulated.faults import Faults
from drivers.rig.campaign import Moment
from drivers.rig.end_requests import RigStopped
from drivers.rig.rig import nothing_to_restore


def times_of_kill(world: Any) -> list[float]:
    """In the soak, at the ramp's begin, between sweeps, in the first and the second repeat, after the last."""
    begun = [event["time"] for event in world.store.events_of("sweep begun")]
    ramps = [event["time"] for event in world.store.events_of("oven")]
    return [ramps[0] + 40.0, ramps[1] + 0.05, begun[0] - 10.0, begun[1] + 0.4, begun[1] + 1.2, begun[2] + 0.9]


def test_ends_as_if_it_had_never_been_killed(
    world_of: Callable[..., Any], killed_at: Callable[[Any, float], None]
) -> None:
    undisturbed = world_of()
    undisturbed.run()
    for moment in times_of_kill(undisturbed):
        world = world_of()
        killed_at(world, moment)
        before = world.digests()
        world.renew()
        assert world.run().missing == 0
        assert before.items() <= world.digests().items()
        assert world.digests() == undisturbed.digests(), f"killed at {moment:.2f} s"
        assert world.at_rest()


def test_what_a_real_oven_passes_meanwhile_is_missed(world: Any, killed_at: Callable[[Any, float], None]) -> None:
    """The very rig goes on: its oven ramps for eighty seconds while nobody looks."""
    killed_at(world, 90.0)
    assert world.digests() == {}
    assert world.parts.body.regulating
    began = world.parts.body.plate
    del world.parts.clock.sleep  # the clock goes on without the killer
    world.parts.clock.sleep(80.0)
    passed = world.parts.body.plate
    assert began < 24.0
    assert 24.9 < passed < 25.5
    world.rig = replace(world.rig, restore=nothing_to_restore)
    outcome = world.run()
    assert (outcome.finished, outcome.missing) == (2, 1)
    (missing,) = world.store.events_of("missing")
    assert missing["step"] == 0
    assert missing["place"] == "24 °C up 1 V"
    assert missing["why"].startswith("passed: 2")
    assert sorted(world.store.kept) == [1, 2]
    assert world.worst_error() < 0.02  # and none of them at a wrong temperature
    # nobody told the oven to begin its ramp anew: it was in it
    assert [event["command"] for event in world.store.events_of("oven")] == ["ramp", "ramp", "safe"]


def test_missed_sweeps_are_fetched_when_asked_for(world: Any, killed_at: Callable[[Any, float], None]) -> None:
    world.plate.before = lambda: world.parts.server.inject(Faults(dead_inputs=frozenset({"cDAQ1Mod1/ai1"})))
    first = world.run()
    assert (first.finished, first.missing) == (0, 3)
    world.renew()
    assert world.run().made_now == 0  # given up is given up
    world.renew()
    again = world.run(again=True)
    assert (again.finished, again.missing, again.made_now) == (3, 0, 3)
    attempts = [(event["step"], event["attempt"]) for event in world.store.events_of("sweep begun")]
    assert attempts[-3:] == [(0, 4), (1, 4), (2, 4)]  # three rejected before, none of them overwritten
    assert len(set(attempts)) == len(attempts)
    assert [(step, number) for step, number, _ in world.store.aside] == [
        (s, n) for s in range(3) for n in (1, 2, 3)
    ]


def test_the_time_left_is_that_from_where_the_ramp_begins_again(world_of: Callable[..., Any]) -> None:
    """It was that of the whole leg until the soak before the ramp was over."""
    world = world_of(programme={"highest": 40.0})

    def stopping(moment: Moment) -> None:
        if moment.done == 6:
            raise RigStopped("a door was opened", "close it")

    with pytest.raises(RigStopped):
        world.run(observer=stopping)
    world.renew()
    moments: list[Moment] = []
    assert world.run(observer=moments.append).missing == 0
    first, last = moments[0], moments[-1]
    took = (datetime.fromisoformat(last.date) - datetime.fromisoformat(first.date)).total_seconds()
    assert first.stage.startswith("way to")
    assert first.seconds_left - last.seconds_left == pytest.approx(took, rel=0.3)
    whole = world.protocol.seconds(first.temperature)
    assert first.seconds_left < 0.75 * whole
