import numpy as np
import pytest

from analysis.protocol.limits import Limits
from analysis.protocol.programme import Programme, Settling
from analysis.protocol.protocol import AcquisitionProtocol
from analysis.protocol.sweep import SweepSettings
from app.watch.course import programme_line, set_point_line

PROTOCOL = AcquisitionProtocol(
    SweepSettings(
        kind="logarithmic", band=(100.0, 900.0), duration=1.0, taper=0.1, tail=0.2, repeats=2, levels=(1.0,)
    ),
    Programme(
        lowest=20.0,
        highest=40.0,
        every=10.0,
        legs=("up", "down"),
        ramp_rate=1.0,
        approach_rate=2.0,
        lead=2.0,
        soak_before=600.0,
        settling=Settling(lasting=60.0),
    ),
    Limits(coldest=0.0, hottest=50.0, patch_voltage=100.0),
)


@pytest.mark.parametrize("start", [5.0, 25.0])
def test_the_programme_lasts_as_long_as_its_estimate(start: float) -> None:
    time, temperature = programme_line(PROTOCOL, start)
    assert time[-1] == pytest.approx(PROTOCOL.seconds(start))
    assert temperature[0] == start
    assert (temperature.min(), temperature.max()) == (min(start, 18.0), 42.0)
    assert (np.diff(time) >= 0.0).all()


def test_a_set_point_ramps_from_the_air_holds_and_ends_at_rest() -> None:
    commands = [
        {"command": "ramp", "target": 30.0, "rate": 2.0},
        {"command": "hold"},
        {"command": "ramp", "target": 21.0, "rate": 1.0},
        {"command": "safe"},
    ]
    at, air = np.array([0.0, 120.0, 300.0]), np.array([20.0, 24.0, 24.0])
    time, value = set_point_line(commands, [0.0, 120.0, 240.0, 600.0], at, air, 700.0)
    known = np.isfinite(value)
    assert np.interp([60.0, 180.0, 300.0, 500.0], time[known], value[known]) == pytest.approx(
        [22.0, 24.0, 23.0, 21.0]
    )
    assert np.isnan(value[-1])


def test_an_oven_that_was_told_nothing_yet_has_no_set_point() -> None:
    time, value = set_point_line([], [], np.array([0.0, 60.0]), np.array([20.0, 20.1]), 60.0)
    assert time.size == value.size == 0
