"""An oven that was switched off is seen to cool, or not, whatever oven it is."""

import numpy as np
import pytest

from drivers.ovens.simulated.regulated_oven import Chamber, Heat
from drivers.watchdog.guard import Event, RestRule, RestWatch

RULE = RestRule(22.0)


def verdict(
    chamber: Chamber, air: float, plate: float, power: float = 0.0, noise: float = 0.05, resolution: float = 0.1
) -> tuple[Event, float, float]:
    """Return what the watch says of a chamber under constant power, when, and at which temperature."""
    heat, watch = Heat(chamber, 1.0, air, plate), RestWatch(RULE, 0.0)
    rng = np.random.default_rng(4)
    for second in range(0, 2000):
        if second % 3 == 0:
            seen = resolution * round((heat.air + noise * rng.standard_normal()) / resolution)
            event = watch.see(float(second), seen)
            if event is not None:
                return event, float(second), heat.air
        heat.advance(power)
    raise AssertionError("no verdict")


@pytest.mark.parametrize("capacity", [5e3, 2e4, 6e4])
@pytest.mark.parametrize(
    ("air", "plate"), [(60.0, 60.0), (60.0, 52.0), (45.0, 55.0), (-10.0, -10.0), (22.0, 22.0)]
)
def test_an_oven_that_is_off_is_at_rest(capacity: float, air: float, plate: float) -> None:
    event, seconds, _ = verdict(Chamber(air_capacity=capacity), air, plate)
    assert event is Event.TOWARDS_ROOM
    assert seconds <= 200.0


@pytest.mark.parametrize("start", [22.0, 45.0, 70.0])
def test_a_heater_that_is_welded_on_is_seen(start: float) -> None:
    """The field's: 70 to 142 °C in 15 minutes after OFF, 5 K a minute."""
    chamber = Chamber()
    power = 5.0 / 60.0 * chamber.air_capacity + chamber.wall_conductance * (start - chamber.room)
    event, _, air = verdict(chamber, start, start, power)
    assert event is Event.AWAY
    assert air < start + 8.0


def test_a_heater_that_only_keeps_the_temperature_is_seen() -> None:
    chamber = Chamber()
    event, seconds, _ = verdict(chamber, 60.0, 60.0, chamber.wall_conductance * 38.0)
    assert event is Event.OVERDUE
    assert seconds == RULE.patience


def test_a_compressor_that_goes_on_is_seen() -> None:
    assert verdict(Chamber(), 5.0, 5.0, -1500.0)[0] is Event.AWAY


def test_an_oven_that_cannot_be_read_is_not_at_rest() -> None:
    watch = RestWatch(RULE, 0.0)
    assert watch.see(1.0, 60.0) is None
    assert watch.see(29.0, None) is None
    assert watch.see(31.0, None) is Event.OVERDUE
    assert "cannot be read" in watch.words(31.0, None)


def test_a_heater_that_gives_way_too_slowly_is_no_oven_that_cools() -> None:
    """0.2 K in every `window` of 75 s, 1.6 K in all: only what happens within the window counts."""
    watch = RestWatch(RULE, 0.0)
    seen = [watch.see(float(second), 60.0 - 0.2 * second / RULE.window) for second in range(0, 601, 3)]
    assert set(seen[:-1]) == {None}
    assert seen[-1] is Event.OVERDUE
