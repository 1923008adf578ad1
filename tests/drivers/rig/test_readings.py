import math

import pytest

from drivers.rig.end_requests import RigStopped
from drivers.rig.readings import Patience, Reading


@pytest.mark.parametrize(
    ("air", "plate", "believable"),
    [
        (20.0, 21.0, True),
        (20.0, None, True),
        (math.nan, 20.0, False),
        (20.0, math.inf, False),
        (20.0, 2300.0, False),
        (-273.0, None, False),
    ],
)
def test_what_a_sensor_in_one_piece_can_say(air: float, plate: float | None, believable: bool) -> None:
    assert Reading(air, plate).believable is believable


def test_beyond_the_limits_is_told_with_the_sensor() -> None:
    Reading(60.0, 59.0).require_within(-10.0, 60.0)
    with pytest.raises(RigStopped, match=r"plate temperature 61\.0 °C"):
        Reading(60.0, 61.0).require_within(-10.0, 60.0)
    with pytest.raises(RigStopped, match=r"air temperature -11\.0 °C"):
        Reading(-11.0, 0.0).require_within(-10.0, 60.0)


def test_patience_ends_after_its_limit_and_begins_anew() -> None:
    patience = Patience(30.0)
    patience.bad(100.0, "silence", "look")
    patience.bad(129.0, "silence", "look")
    assert patience.failing
    patience.good()
    assert not patience.failing
    patience.bad(200.0, "silence", "look")
    with pytest.raises(RigStopped, match="silence, for 30 s"):
        patience.bad(230.0, "silence", "look")
