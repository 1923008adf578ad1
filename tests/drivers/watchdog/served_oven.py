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
from drivers.ovens.simulated.regulated_oven import RegulatedOven, Regulator
from drivers.ovens.simulated.served import TcpPort
from drivers.ovens.simulated.thermal import Chamber

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


def say(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def main() -> None:
    clock = SystemClock()
    kind = Welded if "welded" in sys.argv else RegulatedOven
    body = kind(clock, np.random.default_rng(1), LIGHT, Regulator(period=0.05), air=40.0, plate=40.0)
    controller = oven_settings(SETTINGS).simulated(body, clock)
    asked, longest = [time.monotonic()], [0.0]
    inner = controller.receive

    def receive(data: bytes):
        now = time.monotonic()
        longest[0] = max(longest[0], now - asked[0])
        asked[0] = now
        return inner(data)

    controller.receive = receive
    with TcpPort(controller) as port:
        say(port.address)
        for line in sys.stdin:
            if line.strip() == "reset":
                longest[0] = 0.0
            ago = time.monotonic() - asked[0]
            state = {"regulating": body.regulating, "air": body.air, "ago": ago, "longest": max(longest[0], ago)}
            say(json.dumps(state))


if __name__ == "__main__":
    main()
