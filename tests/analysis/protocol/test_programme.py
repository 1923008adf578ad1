from collections.abc import Callable
from typing import Any

import pytest
from pydantic import ValidationError

from analysis.protocol.protocol import AcquisitionProtocol


def test_the_papers_set_points(protocol_of: Callable[..., AcquisitionProtocol]) -> None:
    protocol = protocol_of(programme={"legs": ("up", "down")})
    up, down = protocol.legs
    assert [point.temperature for point in up.set_points] == [float(t) for t in range(0, 61, 2)]
    assert [point.temperature for point in down.set_points] == [float(t) for t in range(60, -1, -2)]
    assert (up.start, up.end, down.start, down.end) == (-2.0, 62.0, 62.0, -2.0)
    assert [point.step for leg in protocol.legs for point in leg.set_points] == list(range(62))
    assert protocol.count == 62


def test_steps_that_are_no_binary_fractions(protocol_of: Callable[..., AcquisitionProtocol]) -> None:
    protocol = protocol_of(programme={"highest": 0.9, "every": 0.3, "tolerance": 0.1, "poll_interval": 1.0})
    assert protocol.programme.temperatures == (0.0, 0.3, 0.6, 0.9)


def test_levels_are_grouped_around_their_temperature(protocol_of: Callable[..., AcquisitionProtocol]) -> None:
    points = protocol_of(sweep={"levels": (0.5, 1.0, 2.0)}).legs[0].set_points
    assert [(p.temperature, p.level, p.offset) for p in points[:4]] == [
        (0.0, 0.5, -1.0),
        (0.0, 1.0, 0.0),
        (0.0, 2.0, 1.0),
        (2.0, 0.5, -1.0),
    ]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"highest": -1.0}, "below lowest"),
        ({"every": 7.0}, "whole steps"),
        ({"every": 5e-324}, "greater than or equal to 0.05"),
        ({"every": 1e-9}, "greater than or equal to 0.05"),
        ({"legs": ("up", "up")}, "twice"),
        ({"tolerance": 1.0}, "0.4 of every"),
        ({"ramp_rate": 4.0, "poll_interval": 5.0}, "at most 3.75 s"),
        ({"ramp_rate": 0.0}, "greater than 0"),
        ({"lowest": 273.15, "highest": 333.15}, "less than or equal to 200"),
    ],
)
def test_nonsense_is_refused(
    protocol_of: Callable[..., AcquisitionProtocol], changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValidationError, match=message):
        protocol_of(programme=changes)


def test_time_left_of_the_papers_cycle(protocol_of: Callable[..., AcquisitionProtocol]) -> None:
    protocol = protocol_of(programme={"lead": 0.0, "soak_before": 900.0, "soak_after": 900.0})
    assert protocol.seconds(0.0) == pytest.approx(
        3 * 3600.0
    )  # 150 min of ramp, and soaks that make it three hours
    assert protocol.seconds(30.0, 0, ramping=True) == pytest.approx(75 * 60.0 + 900.0)
    # a ramp that is begun again at 40 °C: the soak before it, what is left of the leg, and the soak behind
    assert protocol.seconds(40.0, 0, start=40.0) == pytest.approx(900.0 + 50 * 60.0 + 900.0)


def test_is_declared_as_a_recorded_campaign(protocol_of: Callable[..., AcquisitionProtocol]) -> None:
    recorded = protocol_of(programme={"legs": ("up", "down")}).recorded()
    assert recorded.temperatures[:3] == (0.0, 2.0, 4.0)
    assert recorded.directions == ("up", "down")
    assert (recorded.sweep_duration, recorded.tail, recorded.ramp_rate) == (2.0, 0.4, 0.4)
