import numpy as np
import pytest

from analysis.protocol.limits import Limits
from analysis.protocol.protocol import AcquisitionProtocol, Programme, Settling
from analysis.protocol.sweep import SweepSettings
from app.watch.watched import course, set_point_line

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
    found = course(PROTOCOL, start)
    assert found.time[-1] == pytest.approx(PROTOCOL.seconds(start))
    assert found.temperature[0] == start
    assert (found.temperature.min(), found.temperature.max()) == (min(start, 18.0), 42.0)
    assert (np.diff(found.time) >= 0.0).all()
    assert found.asked.tolist() == [20.0, 30.0, 40.0, 40.0, 30.0, 20.0]
    assert np.interp(found.asked_at, found.time, found.temperature) == pytest.approx(found.asked)


def test_a_campaign_that_is_continued_has_the_rest_of_its_programme_before_it() -> None:
    """Two of the three sweeps up are there: from the room to one lead before the third, soak, then on."""
    found = course(PROTOCOL, 22.0, done={0, 1}, begun={0})
    corners = [22.0, 38.0, 38.0, 42.0, 42.0, 42.0, 18.0, 18.0]
    assert found.temperature.tolist() == corners
    minutes = np.cumsum([0.0, 16.0 / 2.0, 10.0, 4.0, 0.0, 10.0, 24.0, 0.0])
    assert found.time / 60.0 == pytest.approx(minutes)
    assert found.asked.tolist() == [40.0, 40.0, 30.0, 20.0]
    assert found.asked_at[0] / 60.0 == pytest.approx(8.0 + 10.0 + 2.0)


def test_an_oven_that_is_still_on_its_ramp_goes_on() -> None:
    found = course(PROTOCOL, 33.0, done={0, 1}, begun={0}, ramping=0)
    assert found.temperature[:2].tolist() == [33.0, 42.0]
    assert found.time[1] == pytest.approx(9.0 * 60.0)


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
