"""Thermometers beside the cards: read through their simulated counterparts, by themselves and in a campaign."""

from typing import Any

import numpy as np
import pytest

from drivers.clock import VirtualClock
from drivers.ovens.error import OvenError
from drivers.ovens.simulated.controller import MemoryTransport
from drivers.ovens.simulated.regulated_oven import RegulatedOven
from drivers.thermometers.thermometer import THERMOMETERS
from tests.drivers.ovens.served import Disturbed, silenced

DECLARED: dict[str, dict[str, Any]] = {
    "modbus-map": {
        "sensors": [{"at": 0, "table": "input", "scale": 0.1}, {"at": 7, "type": "float32", "unit": "degF"}]
    },
    "scpi": {"sensors": [{"query": "MEAS:TEMP? (@101)"}, {"query": "READ?", "answer": "{value} K", "unit": "K"}]},
}


@pytest.fixture(params=DECLARED)
def opened(request: pytest.FixtureRequest) -> Any:
    clock = VirtualClock()
    body = RegulatedOven(clock, np.random.default_rng(1), air=60.0, plate=31.7)
    declared = {"kind": request.param, "port": "none", "timeout": 0.2, **DECLARED[request.param]}
    settings = THERMOMETERS.find(request.param).model_validate(declared)
    instrument = settings.simulated(body, clock)
    assert instrument is not None
    line = Disturbed(instrument)
    return settings.open(clock, MemoryTransport(line, clock)), line, body


def test_reads_every_sensor_on_the_plate(opened: Any) -> None:
    thermometer, _, body = opened
    assert thermometer.temperatures() == pytest.approx([body.plate] * 2, abs=0.051)


def test_a_silent_one_is_told_and_comes_back(opened: Any) -> None:
    thermometer, line, body = opened
    line.always = silenced
    with pytest.raises(OvenError, match="answer"):
        thermometer.temperatures()
    line.always = lambda answer: [answer]
    assert thermometer.temperatures() == pytest.approx([body.plate] * 2, abs=0.051)


def test_closed_twice_it_answers_no_more(opened: Any) -> None:
    thermometer, *_ = opened
    thermometer.close()
    thermometer.close()
    with pytest.raises(OvenError, match="closed"):
        thermometer.temperatures()
