from collections.abc import Callable
from typing import Any

import pytest

from analysis.protocol.objections import Hardware, objections
from analysis.protocol.protocol import AcquisitionProtocol


def test_none_against_the_papers_protocol(
    protocol_of: Callable[..., AcquisitionProtocol], hardware_of: Callable[..., Hardware]
) -> None:
    assert objections(protocol_of(), hardware_of()) == ()


@pytest.mark.parametrize(
    ("changes", "hardware", "key", "message"),
    [
        ({"sweep": {"levels": (1.0, 5.0)}}, {}, "sweep.levels", "output card's range"),
        ({"sweep": {"levels": (4.0,)}}, {"drive_gain": 30.0}, "sweep.levels", "rated for 100 V"),
        (
            {},
            {"drive_gain": 5.0, "rated_force": 4.0},
            "sweep.levels",
            "at most 0.8 V: the exciter is rated for 4 N",
        ),
        ({}, {"sample_rate": 3200.0}, "sweep.band", "cards.sample_rate"),
        ({"programme": {"lowest": -4.0}}, {}, "programme.lowest", "-6 °C"),
        ({"limits": {"hottest": 61.0}}, {}, "programme.highest", "limits.coldest and limits.hottest"),
        ({"programme": {"approach_rate": 3.0}}, {}, "programme.approach_rate", "at most 2 K/min"),
        (
            {"programme": {"ramp_rate": 2.5, "approach_rate": 1.0, "poll_interval": 2.0}},
            {},
            "programme.ramp_rate",
            "steepest",
        ),
        ({"sweep": {"band": (0.1, 1.5)}}, {}, "sweep.band", "bands are in Hz"),
        ({"sweep": {"duration": 60.0}, "limits": {"drift": 2.0}}, {}, "sweep.duration", "at most 1 K (150 s)"),
        ({"sweep": {"levels": (0.1, 0.2, 0.3), "duration": 16.0}}, {}, "sweep.duration", "3 level(s)"),
        ({"limits": {"drift": 0.01}}, {}, "limits.drift", "ramp moves"),
    ],
)
def test_each_reason_is_named_with_its_remedy(
    protocol_of: Callable[..., AcquisitionProtocol],
    hardware_of: Callable[..., Hardware],
    changes: dict[str, Any],
    hardware: dict[str, float],
    key: str,
    message: str,
) -> None:
    found = objections(protocol_of(**changes), hardware_of(**hardware))
    assert [objection.key for objection in found] == [key]
    (one,) = found
    assert message in f"{one.seen} {one.allowed} {one.remedy}"


def test_all_reasons_at_once(
    protocol_of: Callable[..., AcquisitionProtocol], hardware_of: Callable[..., Hardware]
) -> None:
    protocol = protocol_of(sweep={"levels": (9.0,), "duration": 200.0}, limits={"drift": 20.0})
    found = objections(protocol, hardware_of(oven_max_rate=0.3))
    assert {one.key for one in found} == {
        "sweep.levels",
        "programme.ramp_rate",
        "programme.approach_rate",
        "sweep.duration",
    }
