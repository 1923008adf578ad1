"""A simulated Eurotherm 2400 or 3500."""

import math

from drivers.ovens import eurotherm as programmer
from drivers.ovens.eurotherm import AUTOMATIC, MANUAL, MODEL_2400, Registers
from drivers.ovens.simulated.controller import ModbusServer, float_words, words_float
from drivers.ovens.simulated.regulated_oven import RegulatedOven

FLOATS = 0x8000
PROGRAMS = range(programmer.PROGRAMS + programmer.PROGRAM, programmer.PROGRAMS + 20 * programmer.PROGRAM)


class SimulatedEurotherm(ModbusServer):
    """Answers for the registers a ramp needs, as scaled integers and as floats.

    Parameters
    ----------
    oven : RegulatedOven
    registers : Registers
        Which model it is.
    address : int
    decimals : int
        Of temperatures.
    low, high : float
        Its own set-point limits, degrees Celsius: beyond them it clamps without a word.

    Attributes
    ----------
    locked : bool
        Acknowledges writes without effect, as with a locked keyboard.
    sensor_broken : bool
    alarms : int
        Summary word (3500).
    unit : int
        Of its temperatures: 0 for degrees Celsius (2400).
    programmer : bool
        Whether one is fitted (2400).
    writes : list of tuple
        Register and value of every write, oldest first: what its memory has to bear.
    """

    def __init__(
        self,
        oven: RegulatedOven,
        registers: Registers = MODEL_2400,
        address: int = 1,
        decimals: int = 1,
        low: float = -100.0,
        high: float = 300.0,
    ) -> None:
        super().__init__(address)
        self._oven = oven
        self._at = registers
        self._scale = 10**decimals
        self._low, self._high = low, high
        self._target = oven.working
        self._rate = 0.0
        self._rate_disable = 1
        self._mode = MANUAL
        self.locked = False
        self.sensor_broken = False
        self.alarms = 0
        self.unit = 0
        self.programmer = registers is MODEL_2400
        self._segments: dict[int, float] = {}
        self._number, self._status = 1, programmer.RESET
        self.writes: list[tuple[int, float]] = []

    def read_word(self, register: int) -> int:
        """Return a scaled integer, or half of a float."""
        if register >= FLOATS:
            whole, half = divmod(register - FLOATS, 2)
            if _is_time(whole):
                return (round(1e3 * self._value(whole)[0]) >> (0 if half else 16)) & 0xFFFF
            return float_words(self._value(whole)[0], low_first=False)[half]
        value, scale = self._value(register)
        return round(value * scale) & 0xFFFF

    def write_words(self, register: int, words: tuple[int, ...]) -> None:
        """Store a scaled integer, or a whole float."""
        if register >= FLOATS:
            register = (register - FLOATS) // 2
            value = (
                ((words[0] << 16) + words[1]) / 1e3 if _is_time(register) else words_float(words, low_first=False)
            )
        else:
            _, scale = self._value(register)
            value = (words[0] - 0x10000 if words[0] & 0x8000 else words[0]) / scale
        if self._read_only(register):
            raise ValueError(f"register {register} is read only")
        self.writes.append((register, value))
        if not self.locked:
            self._store(register, value)

    def _value(self, register: int) -> tuple[float, int]:
        at, oven = self._at, self._oven
        match register:
            case at.temperature:
                return oven.measured, self._scale
            case at.target:
                return self._target, self._scale
            case at.working_set_point:
                return oven.working, self._scale
            case at.rate:
                return self._rate, self._scale
            case at.mode:
                return self._mode, 1
            case at.output:
                return 100.0 * oven.output, 10
            case at.rate_disable:
                return self._rate_disable, 1
            case at.sensor_break:
                return float(self.sensor_broken), 1
            case at.alarms:
                return self.alarms, 1
            case at.unit:
                return self.unit, 1
        if self.programmer:
            return self._programmed(register)
        raise LookupError(register)

    def _programmed(self, register: int) -> tuple[float, int]:
        match register:
            case programmer.SELECTED:
                return 0, 1
            case programmer.LOCAL:
                return self._target, self._scale
            case programmer.NUMBER:
                return self._number, 1
            case programmer.STATUS:
                over = self._status == programmer.RUN and not self._oven.regulating and self._mode == AUTOMATIC
                return (programmer.COMPLETE if over else self._status), 1
        if register in PROGRAMS:
            return self._segments.get(register, 0.0), 1
        raise LookupError(register)

    def _read_only(self, register: int) -> bool:
        at = self._at
        return register in (at.temperature, at.working_set_point, at.sensor_break, at.alarms)

    def _store(self, register: int, value: float) -> None:
        at = self._at
        if register == at.target:
            self._target = min(max(value, self._low), self._high)
        elif register == at.rate:
            self._rate = round(value, 1)  # its display's resolution
        elif register == at.rate_disable:
            self._rate_disable = int(value)
        elif register == at.mode:
            self._mode = int(value)
        elif register == at.output and value != 0.0:
            raise ValueError("only output 0 is simulated")
        elif register in PROGRAMS:
            self._segments[register] = value
            return
        elif register == programmer.LOCAL:
            self._target = min(max(value, self._low), self._high)
        elif register == programmer.NUMBER:
            self._number = int(value)
        elif register == programmer.STATUS:
            self._status = int(value)
            self._oven.stop_at = math.inf
        self._drive(begun=register == programmer.STATUS)

    def _drive(self, *, begun: bool) -> None:
        if self._mode != AUTOMATIC:
            self._oven.stop()
            return
        if self._status == programmer.RUN:
            if begun:
                self._run()
            return
        disabled = self._at.rate_disable is not None and self._rate_disable
        rate = math.inf if self._rate == 0.0 or disabled else self._rate
        self._oven.go(self._target, rate)

    def _run(self) -> None:
        """Begin a program that is a ramp, a dwell and an end without power; no other is simulated."""
        base = programmer.PROGRAMS + self._number * programmer.PROGRAM
        ramp, dwell, end = (base + programmer.SEGMENT * number for number in (1, 2, 3))
        kinds = [self._segments.get(segment + programmer.KIND, programmer.END) for segment in (ramp, dwell, end)]
        if kinds != [programmer.RAMP, programmer.DWELL, programmer.END]:
            raise ValueError(f"a program of segments {kinds} is not simulated")
        self._oven.run(
            min(max(self._segments[ramp + programmer.TARGET], self._low), self._high),
            self._segments[ramp + programmer.RATE_OR_TIME],
            self._segments[dwell + programmer.RATE_OR_TIME]
            if self._segments.get(end + programmer.END_TYPE) == programmer.OUTPUT_OFF
            else math.inf,
        )


def _is_time(register: int) -> bool:
    """Whether a register of a program holds the dwell's time; it is the second segment's."""
    inside = (register - programmer.PROGRAMS) % programmer.PROGRAM
    return register in PROGRAMS and inside == 2 * programmer.SEGMENT + programmer.RATE_OR_TIME
