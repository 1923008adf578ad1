from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from drivers.ni.modules import NI_9234
from drivers.ni.simulated.faults import FailingCall, Faults
from drivers.ni.simulated.surroundings import Surroundings, room


def test_devices_are_named_by_their_slots(surroundings: Surroundings) -> None:
    assert list(surroundings.devices()) == ["cDAQ1Mod1", "cDAQ1Mod2", "cDAQ1Mod3"]
    more = replace(surroundings, modules=surroundings.modules | {8: NI_9234})
    assert more.devices()["cDAQ1Mod8"] is NI_9234
    assert "cDAQ1Mod8/ai3" in more.terminals()


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"modules": {0: NI_9234}}, "slots 1 to 8"),
        ({"sensors": {"cDAQ1Mod1/ai7": 0}}, "cDAQ1Mod1/ai7"),
        ({"output": "cDAQ1Mod1/ao0"}, "cDAQ1Mod1/ao0"),
        ({"thermocouples": {"cDAQ1Mod4/ai0": room}}, "cDAQ1Mod4/ai0"),
        ({"memory": -1.0}, "0 to 60"),
    ],
)
def test_wires_to_nowhere_are_refused(surroundings: Surroundings, change: dict[str, Any], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        replace(surroundings, **change)


def test_room_is_at_twenty_degrees() -> None:
    assert np.array_equal(room(np.arange(3.0)), [20.0, 20.0, 20.0])


def test_faults_that_make_no_sense_are_refused() -> None:
    with pytest.raises(ValueError, match="negative"):
        FailingCall("StartTask", 200_010)
    with pytest.raises(ValueError, match="at least 1"):
        FailingCall("StartTask", -200_010, first=0)
    with pytest.raises(ValueError, match="later"):
        Faults(unplugged=(3.0, 3.0))
    with pytest.raises(ValueError, match="stalled"):
        Faults(stalled=-1.0)


@pytest.mark.parametrize(("first", "times", "struck"), [(1, 1, [1]), (3, 2, [3, 4]), (2, 99, [2, 3, 4, 5])])
def test_failing_call_strikes_when_it_is_told_to(first: int, times: int, struck: list[int]) -> None:
    fault = FailingCall("StartTask", -200_010, first=first, times=times)
    assert [count for count in range(1, 6) if fault.strikes(count)] == struck
