"""Temperatures that cannot be true are asked for again, and sensors that lie are found out."""

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from analysis.plate_temperature.plate_sensors import PlateReading, PlateSensors
from drivers.clock import VirtualClock
from drivers.ovens import f4t
from drivers.ovens.error import OvenError
from drivers.ovens.expiry import Expiring
from drivers.ovens.settings import open_oven, oven_settings
from drivers.ovens.simulated import votsch as simulated_votsch
from drivers.ovens.simulated.controller import Delivery, MemoryTransport
from drivers.ovens.simulated.regulated_oven import RegulatedOven
from drivers.rig.end_requests import RigStopped
from drivers.rig.readings import CheckedSensor, Reading, require_agreement, require_celsius
from tests.drivers.ovens.served import Disturbed

World = Any


def sensor(*answers: float) -> tuple[CheckedSensor, Iterator[float]]:
    """Return a sensor asked every 5 s in an oven that ramps by 3 K/min at most, and what it has left to say."""
    left, times = iter(answers), iter(range(0, 10_000, 5))
    return CheckedSensor(lambda: next(left), lambda: float(next(times)), 3.0), left


def test_a_glitch_is_asked_again_and_a_jump_believed() -> None:
    asked, left = sensor(20.0, 20.2, 0.0, 20.4, 20.5, 35.0, 35.1, 35.2)
    assert [asked.read() for _ in range(6)] == [20.0, 20.2, 20.4, 20.5, 35.1, 35.2]
    assert list(left) == []


def test_a_first_answer_that_was_none_does_no_lasting_harm() -> None:
    asked, _ = sensor(0.0, 20.0, 20.0, 20.1)
    assert [asked.read() for _ in range(3)] == [0.0, 20.0, 20.1]


class Tampered:
    """An oven or cards whose temperatures pass through a function first."""

    def __init__(self, inner: Any, method: str, change: Callable[[Any], Any]) -> None:
        self._inner, self._method, self._change = inner, method, change

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._inner, name)
        return (lambda: self._change(found())) if name == self._method else found


def lying(world: World, part: str, change: Callable[[Any], Any]) -> World:
    """Let a sensor of a world lie."""
    opened = f"open_{part}"
    method = "temperature" if part == "oven" else "temperatures"
    inner = getattr(world.rig, opened)
    world.rig = replace(world.rig, **{opened: lambda: Tampered(inner(), method, change)})
    return world


@pytest.mark.parametrize("part", ["oven", "cards"])
@pytest.mark.parametrize("glitch", [0.0, 45.0, 49.9])
def test_single_glitches_cost_no_set_point(world_of: Callable[..., World], part: str, glitch: float) -> None:
    """Every eleventh answer is another number, well within the limits: a late or a damaged one."""
    count = iter(range(1_000_000))

    def change(true: Any) -> Any:
        return true if next(count) % 11 else glitch + 0.0 * true

    world = lying(world_of(), part, change)
    outcome = world.run()
    assert (outcome.finished, outcome.missing) == (3, 0)
    assert world.worst_error() < 0.02


def test_a_thermocouple_that_shows_three_quarters_of_the_rise_is_found_out(world_of: Callable[..., World]) -> None:
    programme = {"lowest": 36.0, "highest": 40.0, "watch": "air", "soak_before": 300.0}
    world = lying(world_of(programme=programme), "cards", lambda true: 22.0 + 0.75 * (true - 22.0))
    with pytest.raises(RigStopped, match="after the soak the air reads"):
        world.run()
    assert world.store.kept == {}
    assert world.at_rest()


@pytest.mark.parametrize(
    "change",
    [
        lambda true, rng: 22.0 + 0.02 * rng.standard_normal(true.shape),
        lambda true, rng: true + 3.0,
        lambda true, rng: 0.0 * true,
        lambda true, rng: np.nan * true,
    ],
    ids=["plausible", "step", "zero", "open"],
)
def test_a_sensor_that_fails_is_named_and_no_wrong_sweep_kept(
    world: World, change: Callable[[Any, Any], Any]
) -> None:
    """It fails between the first two set-points, to a value that the plate had before as well."""
    rng = np.random.default_rng(1)
    lying(world, "cards", lambda true: change(true, rng) if world.parts.body.plate > 24.9 else true)
    with pytest.raises(RigStopped, match=r"the plate's sensor .*limits.lost_after"):
        world.run()
    assert [sweep.step for sweep in world.store.kept.values()] == [0]
    assert world.at_rest()


def two_thermocouples(world: World, change: Callable[[float], float]) -> World:
    """Wire a second thermocouple, which reads what `change` makes of the first."""
    return lying(world, "cards", lambda true: np.append(true, [change(float(value)) for value in true]))


def test_of_two_sensors_the_wrong_one_is_left_out(world: World) -> None:
    def fallen(true: float) -> float:
        return float(world.parts.body.air) if world.parts.body.plate > 24.9 else true

    assert two_thermocouples(world, fallen).run().finished == 3
    (event,) = world.store.events_of("sensor left out")
    assert event["what"].startswith("the plate's sensor 2 ")
    for sweep in world.store.kept.values():
        assert sweep.temperature == pytest.approx(24.0 + 2.0 * sweep.step, abs=0.4)
    assert world.worst_error() < 0.02


def test_a_label_in_doubt_says_so(world_of: Callable[..., World]) -> None:
    """A sensor of which one of two cannot be told wrong: 0.8 K apart throughout."""
    world = two_thermocouples(world_of(), lambda true: true + 0.8)
    assert world.run().finished == 3
    assert "apart, and it is not clear which is wrong" in world.store.kept[2].doubt
    assert world.store.events_of("finished")[2]["doubt"] == world.store.kept[2].doubt
    assert world.store.events_of("temperature in doubt")


def test_no_doubt_of_sound_sensors(world: World) -> None:
    two_thermocouples(world, lambda true: true + 0.3).run()
    assert [sweep.doubt for sweep in world.store.kept.values()] == ["", "", ""]
    assert world.store.events_of("temperature in doubt") == world.store.events_of("sensor left out") == []


@pytest.mark.parametrize(
    ("unit", "of"), [("Fahrenheit", lambda t: 1.8 * t + 32.0), ("kelvin", lambda t: t + 273.15)]
)
def test_another_unit_is_found_out_before_anything_moves(
    world_of: Callable[..., World], unit: str, of: Callable[[float], float]
) -> None:
    world = lying(world_of(), "oven", of)
    for runs in (1, 2):  # "run the same command again" must not get past it
        with pytest.raises(RigStopped, match=unit):
            world.run()
        assert [event["command"] for event in world.store.events_of("oven")] == ["safe"] * runs
    assert world.store.events_of("begun") == []


def test_a_stuck_sensor_is_found_out_within_minutes(world: World) -> None:
    held: list[Any] = []

    def change(true: Any) -> Any:
        if world.parts.body.plate > 25.0 and not held:
            held.append(np.array(true))
        return held[0] if held else true

    lying(world, "cards", change)
    with pytest.raises(RigStopped, match="stuck at 25"):
        world.run()
    # 1 K until its readings are refused, and 2 K in the 60 s of limits.lost_after for which that may last
    assert world.parts.body.plate < 30.0
    assert all(abs(sweep.temperature - 24.0) < 0.2 for sweep in world.store.kept.values())
    assert world.at_rest()


def test_what_cannot_be_judged_is_not() -> None:
    require_agreement(Reading(40.0, None), None)
    require_agreement(Reading(40.0, 30.0), None)
    require_agreement(Reading(40.0, 30.0), 29.0)  # still on its way
    require_agreement(Reading(40.0, 38.5), 38.5)
    require_celsius(Reading(70.0, None))
    require_celsius(Reading(40.0, 22.0))  # hot from the last run


@pytest.mark.parametrize(
    ("kind", "checksum"),
    [("votsch-ascii2", False), ("espec-p300", False), ("watlow-f4t", True), ("eurotherm-2400", True)],
)
def test_what_gets_through_a_damaged_line(kind: str, checksum: bool) -> None:
    """One answer in ten has a wrong bit: nothing gets through a checksum, and nothing far off without one."""
    clock, rng = VirtualClock(), np.random.default_rng(3)
    body = RegulatedOven(clock, np.random.default_rng(7), air=20.0, plate=20.0)
    given = {"kind": kind, "port": "simulated", "minimum": -5.0, "maximum": 65.0, "max_rate": 2.0, "timeout": 0.5}
    settings = oven_settings(given | {"lost_after": 3600.0})
    line = Disturbed(settings.simulated(body, clock))
    oven = open_oven(settings, clock, MemoryTransport(line, clock))
    oven.ramp_to(60.0, 1.0)

    def damaged(answer: Delivery) -> list[Delivery]:
        data = bytearray(answer.data)
        if rng.random() < 0.1:
            data[rng.integers(len(data))] ^= 1 << rng.integers(8)
        return [Delivery(answer.delay, bytes(data))]

    line.always = damaged
    asked = CheckedSensor(oven.temperature, clock.now, 2.0)
    errors = []
    for _ in range(2000):
        clock.sleep(2.0)
        with suppress(OvenError):  # three damaged answers in a row: no reading, which a campaign bears
            errors.append(abs(asked.read() - body.measured))
        with suppress(OvenError):
            if isinstance(oven, Expiring):
                oven.renew()
    assert len(errors) > 1950
    assert max(errors) < (0.2 if checksum else 1.5)


@pytest.mark.parametrize("kind", ["watlow-f4t", "votsch-ascii2", "espec-p300"])
def test_a_programme_beyond_the_controller_s_own_limits_is_refused_before_anything_moves(
    world_of: Callable[..., Any], kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Only the last leg would have met them, hours later."""
    world = world_of(kind, programme={"highest": 40.0})
    controller = world.parts.controller._controller
    if kind == "watlow-f4t":
        controller._floats[f4t.HIGH_LIMIT] = 41.0
    elif kind == "espec-p300":
        controller._high = 41.0
    else:
        monkeypatch.setattr(
            simulated_votsch, "CHANNELS", (("CV01", "Temperature", -77.0, 41.0), *simulated_votsch.CHANNELS[1:])
        )
    for _ in range(2):  # the same command again is refused again
        with pytest.raises(
            RigStopped, match=r"end at -\d+ and 41 °C; the programme, with its lead, goes to 41\.5"
        ):
            world.run()
    assert abs(world.parts.body.air - 22.0) < 0.2
    assert world.at_rest()


def softened(world_of: Callable[..., World], **programme: Any) -> World:
    """Return a campaign whose plate's resonances fall by 1 % a kelvin, over 14 K."""
    return world_of(programme={"lowest": 24.0, "highest": 38.0, "every": 2.0, **programme})


def deaf(patch: pytest.MonkeyPatch) -> None:
    """Let the judge of the sensors believe everything, as it does what is slow enough."""
    patch.setattr(PlateSensors, "judge", lambda self, now, air, read: PlateReading(float(np.mean(read))))
    patch.setattr(PlateSensors, "fit", lambda *_: True)


def test_a_reading_that_falls_while_the_resonances_stay(world_of: Callable[..., World]) -> None:
    """On the way down from 46 °C the sensor reads 12 K too little below 38 °C."""
    world = softened(world_of, highest=46.0, legs=("down",))
    lying(world, "cards", lambda true: true - 12.0 if world.parts.body.plate < 38.0 else true)
    with pytest.MonkeyPatch.context() as patch:
        deaf(patch)
        world.run()
    kept = world.store.kept
    wrong = {step for step, sweep in kept.items() if sweep.temperature < 30.0}
    assert wrong
    assert {step for step, sweep in kept.items() if sweep.doubt} == wrong
    assert all("the resonances moved by" in kept[step].doubt for step in wrong)
    told = {event["step"]: event.get("doubt") for event in world.store.events_of("finished")}
    assert all(told[step] == kept[step].doubt for step in wrong)


def test_a_campaign_that_is_resumed_knows_its_resonances(world_of: Callable[..., World]) -> None:
    """Interrupted after five sweeps; of the lie after that only those five can tell."""
    world = softened(world_of, highest=46.0, legs=("down",))
    world.store.before_keeping = lambda point: _stop() if point.step == 5 else None
    with pytest.raises(RigStopped, match="for the test"):
        world.run()
    assert sorted(world.store.kept) == [0, 1, 2, 3, 4]
    world.store.before_keeping = lambda point: None
    world.renew()
    lying(world, "cards", lambda true: true - 12.0 if world.parts.body.plate < 36.8 else true)
    with pytest.MonkeyPatch.context() as patch:
        deaf(patch)
        world.run()
    later = {step: sweep.doubt for step, sweep in world.store.kept.items() if step >= 5}
    assert later
    assert all("the resonances moved by" in doubt for doubt in later.values())
    assert not any(sweep.doubt for step, sweep in world.store.kept.items() if step < 5)


def _stop() -> None:
    raise RigStopped("for the test", "")


def test_sound_campaigns_up_and_down_are_not_doubted_by_their_resonances(world_of: Callable[..., World]) -> None:
    world = softened(world_of, legs=("up", "down"))
    assert world.run().finished == 16
    assert not [sweep.doubt for sweep in world.store.kept.values() if sweep.doubt]
