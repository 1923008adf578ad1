"""A line whose every byte is written down beforehand, and simulated ovens in memory."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from drivers.clock import VirtualClock
from drivers.ovens.expiry import Expiring
from drivers.ovens.line import Line, Timing
from drivers.ovens.settings import OvenSettings, open_oven, oven_settings
from drivers.ovens.simulated.controller import MemoryTransport
from drivers.ovens.simulated.regulated_oven import RegulatedOven
from tests.drivers.ovens.served import Disturbed

DECLARED: dict[str, dict[str, Any]] = {
    "modbus-map": {
        "kind": "modbus-map",
        "temperature": {"at": 1, "table": "input", "scale": 0.1},
        "set_point": {"at": 2, "scale": 0.1},
        "working_set_point": {"at": 5, "scale": 0.1},
        "rate": {"at": 35, "type": "float32", "unit": "K/h"},
        "run": {"at": 40, "on": 3, "off": 7},
        "status": {"at": 41, "table": "discrete", "mask": 1},
    },
    "modbus-map in Fahrenheit over TCP": {
        "kind": "modbus-map",
        "framing": "tcp",
        "word_order": "low word first",
        "temperature": {"at": 100, "type": "float32", "unit": "degF"},
        "set_point": {"at": 102, "type": "int32", "scale": 0.01, "offset": 10.0, "unit": "degF"},
        "rate": {"at": 104, "type": "uint16", "scale": 0.001, "unit": "degF/min"},
        "run": {"at": 0, "table": "coil"},
    },
    "modbus-map in steps": {
        "kind": "modbus-map",
        "temperature": {"at": 0x1004, "scale": 0.1},
        "set_point": {"at": 0x1114, "scale": 0.1},
        "rest_at": 20.0,
    },
    "scpi": {
        "kind": "scpi",
        "temperature": {"query": "MEAS:TEMP?", "answer": "TEMP {value} C", "field": 2},
        "set_point": {"query": "SOUR:TEMP?", "command": "SOUR:TEMP {value}", "decimals": 2},
        "working_set_point": {"query": "SOUR:TEMP:WORK?"},
        "rate": {"query": "SOUR:RAMP?", "command": "SOUR:RAMP {value}", "decimals": 3},
        "run": {"on": "OUTP ON", "off": "OUTP OFF", "query": "OUTP?"},
        "status": {"query": "STAT?", "good": ["GOOD"]},
    },
}
"""Controllers of the two kinds that are declared altogether; one has neither ramps nor a switch."""
KINDS = ("eurotherm-2400", "eurotherm-3500", "votsch-ascii2", "espec-p300", "watlow-f4t", *DECLARED)
PROGRAMMED = ("eurotherm-2400", "watlow-f4t")
"""Kinds whose ramps can be programs that end by themselves."""


class ScriptedTransport:
    """Expects each request in turn and gives the answer that stands beside it."""

    def __init__(self, clock: VirtualClock, pairs: list[tuple[bytes, bytes]]) -> None:
        self._clock = clock
        self._pairs = list(pairs)
        self._answer = b""

    def write(self, data: bytes) -> None:
        assert self._pairs, f"unexpected request {data!r}"
        sent, self._answer = self._pairs.pop(0)
        assert data == sent

    def read(self, wait: float) -> bytes:
        answer, self._answer = self._answer, b""
        if not answer:
            self._clock.sleep(wait)
        return answer

    def drain(self) -> None:
        assert self._answer == b"", f"{self._answer!r} was never read"

    def close(self) -> None:
        pass

    def finish(self) -> None:
        assert self._pairs == [], "requests never made"
        assert self._answer == b"", "an answer never read"


@pytest.fixture
def scripted() -> Iterator[Callable[[list[tuple[bytes, bytes]]], Line]]:
    """Return a line that plays a script; leftovers fail the test."""
    transports = []

    def make(pairs: list[tuple[bytes, bytes]]) -> Line:
        clock = VirtualClock()
        transports.append(ScriptedTransport(clock, pairs))
        return Line(transports[-1], clock, Timing(timeout=1.0, retries=0))

    yield make
    for transport in transports:
        transport.finish()


@dataclass
class Rig:
    """A driver and its simulated counterpart in virtual time."""

    clock: VirtualClock
    body: RegulatedOven
    controller: Any
    disturbed: Disturbed
    transport: MemoryTransport
    settings: OvenSettings
    oven: Any = None

    def open(self) -> "Rig":
        self.oven = open_oven(self.settings, self.clock, self.transport)
        return self

    @property
    def rest_at(self) -> float | None:
        """Set-point that takes the place of switching off; None where the oven is switched off."""
        return getattr(self.settings, "rest_at", None)

    @property
    def at_rest(self) -> bool:
        """Whether it neither heats nor cools, or is where it rests instead."""
        return not self.body.regulating or self.body.target == self.rest_at

    def wait(self, seconds: float) -> None:
        """Let time pass, asking for the temperature often enough for every kind, and renewing what expires."""
        end = self.clock.now() + seconds
        while self.clock.now() < end:
            self.clock.sleep(min(10.0, end - self.clock.now()))
            self.oven.temperature()
            if isinstance(self.oven, Expiring):
                self.oven.renew()


def settings_of(kind: str, **changes: Any) -> OvenSettings:
    given = {"kind": kind, "port": "none", "minimum": -5.0, "maximum": 65.0, "max_rate": 2.0, "timeout": 0.5}
    return oven_settings({**given, **DECLARED.get(kind, {}), **changes})


def make_rig(kind: str, **changes: Any) -> Rig:
    clock = VirtualClock()
    body = RegulatedOven(clock, np.random.default_rng(7), air=20.0, plate=20.0)
    settings = settings_of(kind, **changes)
    controller = settings.simulated(body, clock)
    disturbed = Disturbed(controller)
    return Rig(clock, body, controller, disturbed, MemoryTransport(disturbed, clock), settings)


@pytest.fixture
def rig_of() -> Callable[..., Rig]:
    """Return a function from a kind to its oven, open and at rest at 20 °C."""
    return lambda kind, **changes: make_rig(kind, **changes).open()


@pytest.fixture(
    params=[*((kind, {}) for kind in KINDS), *((kind, {"program": 3}) for kind in PROGRAMMED)], ids=str
)
def rig(request: pytest.FixtureRequest) -> Rig:
    """Return every kind of oven in turn, open and at rest at 20 °C."""
    kind, changes = request.param
    return make_rig(kind, **changes).open()
