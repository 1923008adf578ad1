"""A protocol that stands, to be changed one key at a time."""

from collections.abc import Callable
from typing import Any

import pytest

from analysis.protocol.limits import Limits
from analysis.protocol.objections import Hardware
from analysis.protocol.protocol import AcquisitionProtocol, Programme
from analysis.protocol.sweep import SweepSettings

SWEEP: dict[str, Any] = {
    "kind": "logarithmic",
    "band": (100.0, 1500.0),
    "duration": 2.0,
    "taper": 0.1,
    "tail": 0.4,
    "repeats": 3,
    "levels": (1.0,),
}
PROGRAMME: dict[str, Any] = {"lowest": 0.0, "highest": 60.0, "every": 2.0, "ramp_rate": 0.4}
LIMITS: dict[str, Any] = {"coldest": -10.0, "hottest": 70.0, "patch_voltage": 100.0}


@pytest.fixture
def sweep_of() -> Callable[..., SweepSettings]:
    return lambda **changes: SweepSettings(**{**SWEEP, **changes})


@pytest.fixture
def protocol_of() -> Callable[..., AcquisitionProtocol]:
    """Return a function that takes changes as ``sweep=dict``, ``programme=dict``, ``limits=dict``."""

    def make(**changes: dict[str, Any]) -> AcquisitionProtocol:
        return AcquisitionProtocol(
            SweepSettings(**{**SWEEP, **changes.get("sweep", {})}),
            Programme(**{**PROGRAMME, **changes.get("programme", {})}),
            Limits(**{**LIMITS, **changes.get("limits", {})}),
        )

    return make


@pytest.fixture
def hardware_of() -> Callable[..., Hardware]:
    usual = {
        "sample_rate": 51_200.0 / 6.0,
        "output_range": 4.24,
        "drive_gain": 15.0,
        "oven_minimum": -5.0,
        "oven_maximum": 65.0,
        "oven_max_rate": 2.0,
    }
    return lambda **changes: Hardware(**{**usual, **changes})
