"""A simulated chamber with the protocol ASCII-2: temperature, humidity, fan, four measured values, 32 bits."""

import math
import re

from drivers.ovens.simulated.controller import LineController
from drivers.ovens.simulated.regulated_oven import RegulatedOven

START = 1
BITS = ("unused", "Start", "Humidity", *(f"Custom O{i}" for i in range(1, 5)), *("unused",) * 25)
CHANNELS = (
    ("CV01", "Temperature", -77.0, 182.0),
    ("CV02", "Humidity", 0.0, 100.0),
    ("SV01", "Fan speed", 50.0, 100.0),
    *((f"MV{i:02d}", "unused", 0.0, 0.0) for i in range(1, 5)),
)
NUMBER = re.compile(r"-?\d{3,4}\.\d")


class SimulatedVotsch(LineController):
    """A climatic chamber.

    Parameters
    ----------
    oven : RegulatedOven
    address : int
        1 to 32.

    Attributes
    ----------
    locked : bool
        Acknowledges writes without effect, as when it is controlled from its panel.
    tells_ramp : bool
        Reports where the ramp is as its nominal temperature, as some do, instead of the ramp's end.
    """

    def __init__(self, oven: RegulatedOven, address: int = 1) -> None:
        super().__init__(b"\r")
        self._oven = oven
        self._prefix = f"${address:02d}"
        self._nominal = [20.0, 50.0, 80.0, 0.0, 0.0, 0.0, 0.0]
        self._bits = "0" * len(BITS)
        self._rates = (60.0, 60.0)
        self.locked = False
        self.tells_ramp = False

    def answer(self, command: str) -> str:
        """Serve ``?``, ``I``, ``E`` and ``U``; silent to other addresses and letters."""
        if not command.startswith(self._prefix) or len(command) <= len(self._prefix):
            return ""
        letter, words = command[len(self._prefix)], command[len(self._prefix) + 1 :].split()
        match letter:
            case "?":
                return self._description()
            case "I":
                return self._status()
            case "E":
                return self._write(words)
            case "U":
                return self._gradients(words)
        return ""

    def _status(self) -> str:
        actual = [self._oven.measured, 43.2, self._nominal[2], 23.8, 22.2, 25.5, 24.4]
        nominal = list(self._nominal)
        if self.tells_ramp and self._bits[START] == "1":
            nominal[0] = self._oven.working
        values = [value for pair in zip(nominal, actual, strict=True) for value in pair]
        return " ".join(f"{value:06.1f}" for value in values) + f" {self._bits}"

    def _write(self, words: list[str]) -> str:
        *numbers, bits = words or [""]
        if len(numbers) != len(CHANNELS) or not all(NUMBER.fullmatch(word) for word in numbers):
            return "1"
        if len(bits) != len(BITS) or set(bits) - {"0", "1"}:
            return "1"
        nominal = [float(word) for word in numbers]
        if not CHANNELS[0][2] <= nominal[0] <= CHANNELS[0][3]:
            return "2"
        if not self.locked:
            self._nominal, self._bits = nominal, bits
            if bits[START] == "1":
                rate = self._rates[0] if nominal[0] >= self._oven.working else self._rates[1]
                self._oven.go(nominal[0], rate or math.inf)
            else:
                self._oven.stop()
        return "0"

    def _gradients(self, words: list[str]) -> str:
        if len(words) != 4 or not all(NUMBER.fullmatch(word) for word in words):
            return "1"
        if all(float(word) for word in words[:2]):
            return "1"  # one of them at a time
        if not self.locked:
            self._rates = (float(words[0]), float(words[1]))
        return "0"

    def _description(self) -> str:
        # worded and laid out as a real chamber's: the E-string's part, then the I-string's
        names = [name for name, *_ in CHANNELS]
        bits = [f"DO{i:02d}" for i in range(len(BITS))]
        ranges = [
            f"{name}  value min: {low:6.1f}   Value max: {high:6.1f}   {label} "
            if low < high
            else f"{name}  0000.0 {label}"
            for name, label, low, high in CHANNELS
        ]
        labelled = [f"{bit}  {label}" for bit, label in zip(bits, BITS, strict=True)]
        twice = " ".join(f"{name} {name}" for name in names)
        kinds = [
            f"{name}  {kind} {label}"
            for name, label, *_ in CHANNELS
            for kind in ("nominal value", "actual value ")
        ]
        lines = [
            f"ASCII 2 PROTOCOL, E-STRING, CHAMBER WITH {sum(n.startswith('CV') for n in names)} CONTROLLED VALUES",
            f"{self._prefix}E {' '.join(names)} {' '.join(bits)} <CR>",
            " DESCRIPTION: ",
            *ranges,
            *labelled,
            "-" * 78,
            "ASCII 2 PROTOCOL, I-STRING",
            f"{twice} {' '.join(bits)} DESCRIPTION: ",
            *kinds,
            *labelled,
        ]
        return "\r\n".join(lines) + "\r\n"
