"""Campaigns without faults: sweeps at their temperatures, on every oven, up and down, at several levels."""

import itertools
import math
import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from drivers.ovens import f4t
from drivers.ovens.f4t import F4T
from drivers.rig.campaign import Moment
from drivers.rig.end_requests import RigStopped


def test_every_sweep_is_made_at_its_temperature(world: Any) -> None:
    outcome = world.run()
    assert (outcome.finished, outcome.missing, outcome.made_now, world.unsafe) == (3, 0, 3, ())
    for step, sweep in world.store.kept.items():
        assert sweep.step == step
        assert sweep.temperature == pytest.approx(24.0 + 2.0 * step, abs=0.15)
        # the air is ahead by the plate's lag of 30 s, 1 K at this rate once the ramp is steady
        assert sweep.oven_temperature - sweep.temperature == pytest.approx(1.0, abs=0.3)
        assert sweep.plate_temperature_end > sweep.plate_temperature_start - 0.1
    assert world.worst_error() < 0.02
    assert world.at_rest()
    assert world.parts.server.tasks_open() == ()
    assert world.store.events_of("rejected") == world.store.events_of("missing") == []


@pytest.mark.parametrize("kind", ["eurotherm-2400", "eurotherm-3500", "votsch-ascii2", "espec-p300"])
def test_every_other_oven(world_of: Callable[..., Any], kind: str) -> None:
    world = world_of(kind)
    assert world.run().finished == 3
    assert world.worst_error() < 0.02
    assert world.at_rest()


def test_up_and_down_with_two_levels(world_of: Callable[..., Any]) -> None:
    world = world_of(sweep={"levels": (0.5, 1.0)}, programme={"legs": ("up", "down"), "soak_after": 120.0})
    moments: list[Moment] = []
    assert world.run(observer=moments.append).finished == 12
    kept = world.store.kept
    assert [kept[step].direction for step in range(12)] == ["up"] * 6 + ["down"] * 6
    assert [round(kept[step].temperature) for step in range(6, 12, 2)] == [28, 26, 24]
    for step in range(0, 12, 2):  # the group is centred: the first level comes before, the second after
        sign = 1.0 if step < 6 else -1.0
        nominal = round(kept[step].temperature)
        assert sign * (kept[step].temperature - nominal) < sign * (kept[step + 1].temperature - nominal)
    assert world.worst_error() < 0.02
    # told all along, the time left falls and agrees with what then passed
    assert [moment.total for moment in moments] == [12] * len(moments)
    assert all(b.done >= a.done for a, b in itertools.pairwise(moments))
    ended = world.store.events_of("oven")[-1]["time"]  # then the oven is watched until it is seen to cool
    assert moments[0].seconds_left == pytest.approx(ended, rel=0.35)
    assert moments[-1].stage == "last soak"
    assert moments[-1].seconds_left == 120.0


def test_watching_the_air_needs_no_thermocouple(world_of: Callable[..., Any]) -> None:
    world = world_of(programme={"watch": "air"})
    world.parts.wiring.__dict__["thermocouples"] = ()
    assert world.run().finished == 3
    for step, sweep in world.store.kept.items():
        assert sweep.plate_temperature_start is None
        assert sweep.oven_temperature == pytest.approx(24.0 + 2.0 * step, abs=0.15)


def test_nothing_left_to_do_only_brings_the_rig_to_rest(world: Any) -> None:
    world.run()
    before = list(world.store.log_lines)
    world.renew()
    outcome = world.run()
    assert (outcome.finished, outcome.made_now, world.unsafe) == (3, 0, ())
    assert [event["command"] for event in world.store.log_lines[len(before) :]] == ["safe"]


def test_an_oven_that_must_be_asked_more_often_is_asked_during_long_sweeps(world_of: Callable[..., Any]) -> None:
    """An Espec stops when nobody has asked it anything for 30 s, and each sweep lasts 40."""
    sweep = {"duration": 40.0, "taper": 1.0, "repeats": 1}
    programme = {"lowest": 23.0, "highest": 23.0, "ramp_rate": 0.2, "lead": 0.5, "soak_before": 0.0}
    world = world_of("espec-p300", sweep=sweep, programme=programme)
    assert world.run().finished == 1
    assert world.at_rest()


def test_an_oven_that_cannot_get_there_stops_the_campaign(world_of: Callable[..., Any]) -> None:
    world = world_of(
        programme={"lowest": 44.0, "highest": 45.0, "every": 1.0, "settling": {"timeout": 600.0, "lasting": 60.0}}
    )
    world.chamber = replace(world.chamber, heating=50.0)
    world.renew()
    with pytest.raises(RigStopped, match="Can the oven reach it"):
        world.run()
    assert world.at_rest()


def test_time_of_readings_lies_on_a_grid(world: Any) -> None:
    """However long anything takes in between: that is what makes a resumed campaign equal an undisturbed one."""
    seen = []
    moment_of = world.parts.clock.now
    world.run(observer=lambda moment: seen.append(moment_of()))
    # the thermocouple module's own conversion, 1/14 s, and the oven's answer pass before anybody is told
    assert all(math.fmod(time, 3.0) < 0.5 for time in seen)


def test_a_pause_holds_the_oven_and_costs_no_sweep(world_of: Callable[..., Any]) -> None:
    world = world_of()
    polled = {"calls": 0}

    def paused() -> bool:
        polled["calls"] += 1
        return 40 <= polled["calls"] < 60 or 80 <= polled["calls"] < 90

    outcome = world.run(paused=paused)
    assert (outcome.finished, outcome.missing) == (3, 0)
    assert len(world.store.events_of("paused")) == len(world.store.events_of("continued")) == 2
    held = [e for e in world.store.events_of("oven") if e["command"] == "hold"]
    assert [e["purpose"] for e in held] == ["paused", "paused"]
    for begun, ended in zip(world.store.events_of("paused"), world.store.events_of("continued"), strict=True):
        swept = [e["time"] for e in world.store.events_of("sweep begun")]
        assert not any(begun["time"] < t < ended["time"] for t in swept)
    assert world.worst_error() < 0.01
    assert world.at_rest()


def test_every_repeat_is_shown_as_soon_as_it_is_recorded(world_of: Callable[..., Any]) -> None:
    world = world_of()
    world.run()
    assert [(step, repeat) for step, repeat, _ in world.store.shown] == [
        (s, r) for s in range(3) for r in range(2)
    ]
    for step, repeat, record in world.store.shown:
        assert (record.responses[0].astype("f4") == world.store.kept[step].responses[0, repeat]).all()


def test_an_observer_may_stop_the_campaign(world_of: Callable[..., Any]) -> None:
    world = world_of()
    seen: list[Moment] = []

    def observer(moment: Moment) -> None:
        seen.append(moment)
        if moment.done == 1:
            raise RigStopped("enough", "go on later")

    with pytest.raises(RigStopped, match="enough"):
        world.run(observer=observer)
    assert world.at_rest()
    assert sorted(world.store.kept) == [0]
    world.renew()
    assert world.run().finished == 3


def test_a_ramp_stopped_below_zero_is_begun_anew_and_reported_with_its_sign(world_of: Callable[..., Any]) -> None:
    """In a room of -10 °C, where an oven that is off does not warm up by itself; its controller cannot tell."""
    world = world_of(
        oven={"minimum": -20.0}, programme={"lowest": -8.0, "highest": -4.0}, limits={"coldest": -15.0}
    )

    def stop_on_the_panel() -> None:
        world.parts.controller._controller.write_words(f4t.MODE, (f4t.OFF,))

    def after_the_first_sweep() -> None:
        if world.plate.sweeps == 2:
            world.at(world.parts.clock.now() + 7.0, stop_on_the_panel)

    world.chamber = replace(world.chamber, room=-10.0)
    world.renew()
    world.plate.before = after_the_first_sweep
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(F4T, "changed", lambda self: "")
        assert world.run().finished == 3
    (trouble,) = [event["what"] for event in world.store.events_of("trouble")]
    assert re.fullmatch(r"the ramp has halted at -\d+\.\d °C; it is started again", trouble)
