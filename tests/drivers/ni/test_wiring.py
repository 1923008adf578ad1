from typing import Any

import pytest
from pydantic import ValidationError

from drivers.ni.wiring import Wiring

GOOD: dict[str, Any] = {
    "output": "cDAQ1Mod2/ao0",
    "drive_input": "cDAQ1Mod1/ai0",
    "responses": ["cDAQ1Mod1/ai1", "cDAQ1Mod1/ai2"],
    "sample_rate": 8500.0,
}


def test_inputs_begin_with_the_drive() -> None:
    assert Wiring(**GOOD).inputs == ("cDAQ1Mod1/ai0", "cDAQ1Mod1/ai1", "cDAQ1Mod1/ai2")


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"output": "ao0"}, "output"),
        ({"output": "cDAQ1Mod2/ai0"}, "cDAQ1Mod2/ai0"),
        ({"drive_input": "cDAQ1Mod2/ao1"}, "cDAQ1Mod2/ao1"),
        ({"responses": []}, "responses"),
        ({"responses": ["cDAQ1Mod1/ai0"]}, "used 2 times"),
        ({"thermocouples": ["cDAQ1Mod1/ai1"]}, "used 2 times"),
        ({"sample_rate": 8.5}, "sample_rate"),
        ({"coupling": "GND"}, "coupling"),
        ({"thermocouple_type": "X"}, "thermocouple_type"),
        ({"grpc": "labpc"}, "grpc"),
        ({"input_range": float("inf")}, "input_range"),
        ({"channels": 3}, "channels"),
    ],
)
def test_nonsense_is_refused_by_name(change: dict[str, Any], told: str) -> None:
    with pytest.raises(ValidationError, match=told):
        Wiring(**(GOOD | change))
