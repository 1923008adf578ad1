"""The weather's declaration: what it computes, and what it refuses with a sentence."""

import json

import numpy as np
import pytest
from pydantic import ValidationError

from analysis.weather.declared_weather import FaceAir, Weather

AIR = {"air": [[0.0, -10.0], [700.0, 50.0]]}
PLAIN = {"duration": 900.0, "front": AIR, "back": AIR, "thermometer": [{"name": "a", "point": [0.1, 0.1]}]}


def made(**changes):
    return Weather.model_validate_json(json.dumps(PLAIN | changes), strict=True)


def test_air_and_sun_are_straight_in_between_and_held_outside():
    around = FaceAir(air=((0.0, 10.0), (100.0, 30.0)), across=((0.0, 0.0, 4.0), (50.0, 8.0, 0.0)))
    np.testing.assert_allclose(around.air_at(25.0), [15.0, 4.0, 2.0])
    np.testing.assert_allclose(around.air_at(500.0), [30.0, 8.0, 0.0])
    assert around.sun_at(3.0) == 0.0
    assert FaceAir(air=((0.0, 1.0),), sun=((10.0, 0.0), (20.0, 600.0))).sun_at(15.0) == 300.0


def test_the_sun_rises_evenly_from_the_dark_point_to_the_bright_one():
    around = FaceAir(air=((0.0, 1.0),), sun=((0.0, 600.0),), lit=((0.1, 0.0), (0.2, 0.0)))
    points = np.array([[0.0, 0.3], [0.125, -0.2], [0.5, 0.1]])
    np.testing.assert_allclose(around.lit_at(points), [0.0, 0.25, 1.0])


def test_steps_end_at_the_duration():
    times = made(duration=100.0, step=30.0).times
    np.testing.assert_allclose(times, [0.0, 25.0, 50.0, 75.0, 100.0])


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"duration": 1e6, "step": 1.0}, "at most 20000 steps: raise step"),
        ({"front": {"air": [[10.0, 1.0], [5.0, 2.0]]}}, "air: 5 s after 10 s; times must ascend"),
        ({"front": AIR | {"lit": [[0.0, 0.0], [0.1, 0.0]]}}, "lit says where the sun shines, and sun is missing"),
        ({"front": AIR | {"sun": [[0.0, 5.0]], "lit": [[0.1, 0.0], [0.1, 0.0]]}}, "lit: both points are"),
        ({"thermometer": []}, "at least 1 item"),
        ({"thermometer": PLAIN["thermometer"] * 2}, "two thermometers are named 'a'"),
        ({"front": AIR | {"convection": 0.0}, "back": AIR | {"convection": 0.0}}, "initial is missing"),
        ({"edge": AIR | {"sun": [[0.0, 5.0]]}}, "edge takes convection and air only"),
        ({"front": AIR | {"convection": 1e4}}, "less than or equal to 500"),
        ({"front": {"air": [[0.0, 300.0]]}}, "less than or equal to 200"),
    ],
)
def test_what_cannot_be_is_refused(changes, said):
    with pytest.raises(ValidationError, match=said):
        made(**changes)
