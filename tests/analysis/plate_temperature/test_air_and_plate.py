"""A recorded campaign's readings of oven and plate."""

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest

from analysis.plate_temperature.label_check import doubtful_sweeps, offset_change
from analysis.recordings.campaign import Sweep


def sweep(step: int, direction: Literal["up", "down"], plate: float, lag: float = 2.5) -> Sweep:
    sign = 1.0 if direction == "up" else -1.0
    air = plate + sign * lag
    signal = np.zeros((2, 8), dtype=np.float32)
    return Sweep(
        step, direction, 1.0, air, air + 0.1 * sign, "2000-01-01T00:00:00", signal, signal[None],
        plate, plate + 0.1 * sign,
    )  # fmt: skip


def both_ways(scale: float = 0.0) -> list[Sweep]:
    """Sweeps every 5 K up and down, whose plate reads too much by `scale` of what it is above 20 °C."""
    temperatures = np.arange(15.0, 46.0, 5.0)
    made = [sweep(step, "up", float(t)) for step, t in enumerate(temperatures)]
    made += [sweep(10 + step, "down", float(t)) for step, t in enumerate(temperatures[::-1])]
    wrong = [scale * (one.temperature - 20.0) for one in made]
    return [
        replace(
            one,
            plate_temperature_start=(one.plate_temperature_start or 0.0) + off,
            plate_temperature_end=(one.plate_temperature_end or 0.0) + off,
        )
        for one, off in zip(made, wrong, strict=True)
    ]


def test_a_sound_campaign_is_not_doubted() -> None:
    assert doubtful_sweeps(both_ways()) == {}
    assert offset_change(both_ways()) is None


def test_first_sweep_of_a_leg_may_come_before_the_lag_has_grown() -> None:
    sweeps = both_ways()
    assert doubtful_sweeps([sweep(0, "up", 15.0, lag=0.1), *sweeps[1:]]) == {}


@pytest.mark.parametrize("place", [1, 4, 9])
def test_a_reading_that_does_not_fit_the_oven_is_named(place: int) -> None:
    sweeps = both_ways()
    wrong = sweeps[place]
    sweeps[place] = replace(wrong, oven_temperature_start=wrong.oven_temperature_start + 4.0,
                            oven_temperature_end=wrong.oven_temperature_end + 4.0)  # fmt: skip
    found = doubtful_sweeps(sweeps)
    assert list(found) == [place]
    assert f"oven {sweeps[place].oven_temperature:.1f} °C" in found[place]


def test_a_plate_ahead_of_the_air_is_doubted_even_in_a_leg_of_two_sweeps() -> None:
    """Oven 41.8, plate 25.0 on the way down: the thermocouple has failed to a plausible value."""
    first, second = sweep(0, "down", 45.0), sweep(4, "down", 25.0)
    failed = replace(second, oven_temperature_start=41.9, oven_temperature_end=41.8)
    found = doubtful_sweeps([first, failed])
    assert list(found) == [1]
    assert "oven 41.9 °C, plate 24.9 °C" in found[1] or "oven 41.8 °C" in found[1]


def test_a_jump_within_a_sweep_is_doubted() -> None:
    sweeps = both_ways()
    sweeps[3] = replace(sweeps[3], plate_temperature_end=sweeps[3].temperature + 1.2)
    assert list(doubtful_sweeps(sweeps)) == [3]


def test_a_scale_error_is_told_with_its_size() -> None:
    change = offset_change(both_ways(0.05))
    assert change is not None
    assert change[0] == pytest.approx(0.05 * 30.0, rel=0.15)


def test_without_a_sensor_on_the_plate_nothing_is_judged() -> None:
    sweeps = [replace(one, plate_temperature_start=None, plate_temperature_end=None) for one in both_ways()]
    assert doubtful_sweeps(sweeps) == {}
    assert offset_change(sweeps) is None
