"""Damaged serial exchanges: how many wrong temperatures get through a driver, and through a second question.

    python benchmarks/damaged_lines.py [EXCHANGES [KIND ...]]

Half of all answers, and one question in twenty, arrive damaged: a wrong bit, a wrong byte, three wrong bytes, a
byte lost, a byte too many, half of it, twice, or after the time-out, each as often as the others. A temperature is
wrong where it differs by more than 0.3 K from the one that the simulated controller measures. Every hundredth
reading a set-point is sent with its first answer damaged: lost where that raises, or another one holds. Seeded;
the plain way, beside it, is to believe what the driver says.
"""

import sys
import time
from dataclasses import dataclass, field

import numpy as np

from drivers.clock import VirtualClock
from drivers.ovens.error import OvenError
from drivers.ovens.settings import open_oven, oven_settings
from drivers.ovens.simulated.controller import Controller, Delivery, MemoryTransport
from drivers.ovens.simulated.regulated_oven import RegulatedOven
from drivers.rig.readings import CheckedSensor

GIVEN = {"port": "none", "minimum": -5.0, "maximum": 65.0, "max_rate": 2.0, "timeout": 0.5, "lost_after": 3600.0}
KINDS: dict[str, dict[str, object]] = {
    "eurotherm-2400": {},
    "watlow-f4t": {},
    "modbus-map": {
        "temperature": {"at": 1, "scale": 0.1},
        "set_point": {"at": 2, "scale": 0.1},
        "rate": {"at": 3, "scale": 0.1},
        "run": {"at": 4},
    },
    "votsch-ascii2": {},
    "espec-p300": {},
    "scpi": {
        "temperature": {"query": "MEAS:TEMP?"},
        "set_point": {"query": "SOUR:TEMP?", "command": "SOUR:TEMP {value}"},
        "rate": {"query": "SOUR:RAMP?", "command": "SOUR:RAMP {value}", "decimals": 2},
        "run": {"on": "OUTP ON", "off": "OUTP OFF", "query": "OUTP?"},
    },
}
WRONG = 0.3
"""K."""


@dataclass
class DamagedLine:
    """A controller behind a line that damages what is said on it."""

    inner: Controller
    rng: np.random.Generator
    answers: float = 0.5
    questions: float = 0.05
    damaged: int = 0
    once: bool = field(default=False)

    def receive(self, data: bytes) -> list[Delivery]:
        """Pass a question on, and its answer back."""
        if not self.once and self.rng.random() < self.questions:
            data = self._spoilt(Delivery(0.0, data))[0].data
        found = []
        for answer in self.inner.receive(data):
            if self.once or self.rng.random() < self.answers:
                found += self._spoilt(answer)
                self.answers = 0.0 if self.once else self.answers
                self.once = False
            else:
                found.append(answer)
        return found

    def _spoilt(self, answer: Delivery) -> list[Delivery]:
        self.damaged += 1
        rng, data = self.rng, bytearray(answer.data)
        place = int(rng.integers(len(data)))
        match int(rng.integers(8)):
            case 0:
                data[place] ^= 1 << int(rng.integers(8))
            case 1:
                data[place] = int(rng.integers(256))
            case 2:
                data[place : place + 3] = rng.bytes(len(data[place : place + 3]))
            case 3:
                del data[place]
            case 4:
                data.insert(place, int(rng.integers(256)))
            case 5:
                del data[len(data) // 2 :]
            case 6:
                data *= 2
            case 7:
                return [Delivery(answer.delay + float(rng.uniform(0.5, 1.2)), bytes(data))]
        return [Delivery(answer.delay, bytes(data))]


def measure(kind: str, exchanges: int) -> tuple[int, int, int, float, int, int]:
    """Return damaged exchanges; temperatures wrong if believed, if asked again, the worst; set-points, lost."""
    clock = VirtualClock()
    body = RegulatedOven(clock, np.random.default_rng(7), air=20.0, plate=20.0)
    settings = oven_settings({"kind": kind, **GIVEN, **KINDS[kind]})
    controller = settings.simulated(body, clock)
    if controller is None:
        raise AssertionError("all of these are simulated")
    line = DamagedLine(controller, np.random.default_rng(3), answers=0.0, questions=0.0)
    oven = open_oven(settings, clock, MemoryTransport(line, clock))
    oven.ramp_to(60.0, 1.0)
    plain = asked_again = sent = lost = readings = 0
    worst = 0.0

    def ask() -> float:
        nonlocal plain
        value = oven.temperature()
        plain += abs(value - body.measured) > WRONG
        return value

    sensor = CheckedSensor(ask, clock.now, settings.max_rate)
    while line.damaged < exchanges:
        line.answers, line.questions = 0.5, 0.05
        clock.sleep(2.0)
        readings += 1
        try:
            error = abs(sensor.read() - body.measured)
        except OvenError:
            continue  # three in a row: no reading, which a campaign bears
        if error > WRONG:
            asked_again += 1
            worst = max(worst, error)
        if readings % 100 == 0:
            target = 20.0 if readings % 200 else 60.0
            line.answers, line.questions, line.once = 0.0, 0.0, True
            sent += 1
            try:
                oven.ramp_to(target, 1.0)
                lost += abs(body.target - target) > WRONG
            except OvenError:
                lost += 1
            line.once = False
    return line.damaged, plain, asked_again, worst, sent, lost


def main() -> None:
    """Print the table."""
    exchanges = int(sys.argv[1]) if len(sys.argv) > 1 else 100_000
    print("| kind | damaged exchanges | wrong, believed | wrong, asked again | worst [K] | set-points lost |")
    print("|---|---|---|---|---|---|")
    for kind in sys.argv[2:] or KINDS:
        begun = time.process_time()
        damaged, plain, asked_again, worst, sent, lost = measure(kind, exchanges)
        print(f"| {kind} | {damaged} | {plain} | {asked_again} | {worst:.1f} | {lost} of {sent} |", flush=True)
        print(f"{kind}: {time.process_time() - begun:.0f} s", file=sys.stderr)


if __name__ == "__main__":
    main()
