"""A simulated oven in a process of its own, in real time, that outlives every other process of a test.

    python -m tests.drivers.watchdog.served_oven [welded]

Its address is the first line it prints; for every line it reads it prints its state as JSON.
"""

import json
import sys
import time

import numpy as np

from drivers.clock import SystemClock
from drivers.ovens.settings import oven_settings
from drivers.ovens.simulated.regulated_oven import Chamber, RegulatedOven, Regulator
from tests.drivers.ovens.served import TcpPort

SETTINGS = {
    "kind": "watlow-f4t",
    "port": "later",
    "minimum": 0.0,
    "maximum": 80.0,
    "max_rate": 60.0,
    "timeout": 0.3,
    "retries": 1,
    "lost_after": 30.0,
}
LIGHT = Chamber(air_capacity=300.0, plate_capacity=50.0, heating=600.0)
"""Cools by 1 K in a second or two, so that a test sees it within seconds."""


class Welded(RegulatedOven):
    """Its heater's relay is welded on: it heats whatever it was told."""

    def _rest(self) -> None:
        super()._rest()
        self._power = 600.0


class Asked:
    """A controller that notes for how long at most it was not asked anything, s."""

    def __init__(self, inner) -> None:
        self._inner = inner
        self._asked = time.monotonic()
        self.longest = 0.0

    def receive(self, data: bytes):
        self.longest, self._asked = self.silence(), time.monotonic()
        return self._inner.receive(data)

    def silence(self) -> float:
        return max(self.longest, time.monotonic() - self._asked)


def say(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def main() -> None:
    clock = SystemClock()
    kind = Welded if "welded" in sys.argv else RegulatedOven
    body = kind(clock, np.random.default_rng(1), LIGHT, Regulator(period=0.05), air=40.0, plate=40.0)
    controller = Asked(oven_settings(SETTINGS).simulated(body, clock))
    with TcpPort(controller) as port:
        say(port.address)
        for line in sys.stdin:
            if line.strip() == "reset":
                controller.longest = 0.0
            state = {"regulating": body.regulating, "air": body.air, "longest": controller.silence()}
            say(json.dumps(state))


if __name__ == "__main__":
    main()
