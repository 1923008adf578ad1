from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from analysis.experiment import Protocol
from analysis.recordings.campaign import Sweep
from app.files.campaigns.coverage import Place, coverage_problems, missing_places, place_of, places


def protocol(**changes: Any) -> Protocol:
    given = {
        "sweep": "linear",
        "band": (100.0, 1500.0),
        "sweep_duration": 2.0,
        "tail": 0.4,
        "repeats": 3,
        "ramp_rate": 0.4,
        "temperatures": (0.0, 2.0, 20.0),
        "directions": ("up", "down"),
        "levels": (0.5, 1.0),
    }
    return Protocol(**(given | changes))


def sweep(temperature: float, step: int = 0, **changes: Any) -> Sweep:
    silent = np.zeros((1, 1), np.float32)
    made = Sweep(step, "up", 1.0, temperature, temperature, "2024-03-11T08:30:00", silent, silent[None])
    return replace(made, **changes)


def test_places_go_up_and_come_down() -> None:
    asked = places(protocol())
    assert [place.temperature for place in asked if place.level == 1.0] == [0, 2, 20, 20, 2, 0]
    assert len(set(asked)) == 12
    assert asked[0] == Place(0.0, "up", 0.5)


@pytest.mark.parametrize(
    ("reading", "nominal"),
    [
        (0.7, 0.0),
        (1.0, None),
        (1.3, 2.0),
        (-0.79, 0.0),
        (-0.81, None),
        (2.7, 2.0),
        (18.1, 20.0),
        (17.9, None),
        (11.0, None),
    ],
)
def test_reading_belongs_to_a_temperature_it_is_clearly_near(reading: float, nominal: float | None) -> None:
    """0.4 of the gap on the side that is closer, 2 K at most."""
    place = place_of(protocol(), sweep(reading))
    assert (place.temperature if place else None) == nominal


def test_single_temperature_takes_readings_within_two_kelvin() -> None:
    alone = protocol(temperatures=(25.0,))
    assert place_of(alone, sweep(26.9)) is not None
    assert place_of(alone, sweep(27.1)) is None


def test_what_is_missing_is_named_in_the_protocols_order() -> None:
    there = {"a": sweep(0.0), "b": sweep(20.0, level=0.5)}
    asked = protocol(directions=("up",))
    assert [str(place) for place in missing_places(asked, there)] == [
        "0 °C up 0.5 V",
        "2 °C up 0.5 V",
        "2 °C up 1 V",
        "20 °C up 1 V",
    ]


def test_down_leg_must_fall() -> None:
    falling = {"a": sweep(20.0, 0, direction="down"), "b": sweep(2.0, 1, direction="down")}
    assert not list(coverage_problems(protocol(), falling))
    climbing = {"a": sweep(2.0, 0, direction="down"), "b": sweep(20.0, 1, direction="down")}
    (problem,) = coverage_problems(protocol(), climbing)
    assert str(problem) == "b: temperature of step 1 = 20 °C; allowed: below the 2 °C of the step before"


def test_levels_are_ordered_each_for_itself() -> None:
    """All levels at each temperature, or one ramp for each level: both are in order."""
    ramp_each = [(0.0, 1.0), (2.0, 1.0), (20.0, 1.0), (0.0, 0.5), (2.0, 0.5), (20.0, 0.5)]
    sweeps = {f"{n}": sweep(t, n, level=level) for n, (t, level) in enumerate(ramp_each)}
    assert not list(coverage_problems(protocol(), sweeps))
