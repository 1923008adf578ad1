"""A program of limited time in a Eurotherm 2400 with its programmer: ramp, dwell, output off.

Programs lie from register 8192 on, 136 registers each, eight for what they have in general and eight for every
segment; times are milliseconds in two registers at 0x8000 + 2 x address (2000 series communications handbook).
"""

from drivers.ovens.error import Fault, OvenError
from drivers.ovens.expiry import Expiry, of
from drivers.ovens.modbus import ModbusUnit
from drivers.ovens.oven import SetPoint

NUMBER, STATUS, SELECTED, LOCAL, MODE = 22, 23, 15, 24, 273
AUTOMATIC = 0
RESET, RUN, COMPLETE = 1, 2, 16
PROGRAMS, PROGRAM, SEGMENT = 8192, 136, 8
HOLDBACK, RAMP_UNITS, CYCLES = 0, 2, 4
"""Of the program in general; no holdback is 0, minutes are 1."""
KIND, TARGET, RATE_OR_TIME, END_TYPE = 0, 1, 2, 3
"""Of a segment. The end's power stands where other segments have their target."""
RAMP, DWELL, END = 1, 3, 0
OUTPUT_OFF = 2
"""End type: the output goes to the end's power."""
WITHOUT = "Is a programmer fitted? Without oven.program the controller ramps by itself, without an end."


def as_float(register: int) -> int:
    """Return where the float, or the time, of a register stands."""
    return 0x8000 + 2 * register


class EurothermProgram:
    """One of the instrument's programs, overwritten with every ramp.

    Parameters
    ----------
    unit : ModbusUnit
    number : int
        From 1.
    rest_after : float
        How long the target is held before the output goes off, s.
    decimals : int
        Of temperatures.

    Attributes
    ----------
    expiry : Expiry
        Of its dwell.
    """

    def __init__(self, unit: ModbusUnit, number: int, rest_after: float, decimals: int) -> None:
        self._unit = unit
        self._number = number
        self._decimals = decimals
        self._base = PROGRAMS + PROGRAM * number
        self.expiry = Expiry(rest_after)

    @property
    def running(self) -> bool:
        """Whether it ramps or dwells."""
        return self._unit.read(STATUS) == RUN

    def write(self, wanted: SetPoint) -> SetPoint:
        """Write a ramp, the dwell and the end, as far as they do not stand there; return the ramp as taken."""
        put, put_float = self._unit.put, self._unit.put_float
        ramp, dwell, end = (self._base + SEGMENT * segment for segment in (1, 2, 3))
        with of(f"program {self._number}", WITHOUT):
            put(self._base + HOLDBACK, 0, name="holdback type")
            put(self._base + RAMP_UNITS, 1, name="ramp units")
            put(self._base + CYCLES, 1, name="program cycles")
            put(ramp + KIND, RAMP, name="type of segment 1")
            target = put_float(as_float(ramp + TARGET), wanted.target, 0.051, name="target of segment 1")
            tolerance = min(0.051, 0.25 * wanted.rate)  # a rate of zero must not pass
            rate = put_float(as_float(ramp + RATE_OR_TIME), wanted.rate, tolerance, name="rate of segment 1")
            put(dwell + KIND, DWELL, name="type of segment 2")
            milliseconds = round(1e3 * self.expiry.rest_after)
            self._unit.put_long(as_float(dwell + RATE_OR_TIME), milliseconds, name="time of segment 2")
            put(end + KIND, END, name="type of segment 3")
            put_float(as_float(end + TARGET), 0.0, 0.051, name="power at the end")
            put(end + END_TYPE, OUTPUT_OFF, name="end type")
        return SetPoint(target, rate)

    def start(self, here: float, harmless: float, ramp: float) -> None:
        """Start it, or start it anew; reset, it returns to a harmless set-point.

        The set-point it may start from is the temperature only while the program before still runs, and in the
        moment between its reset and the new start: nothing else would end by itself.

        Parameters
        ----------
        here : float
            Temperature it starts from, degrees Celsius.
        harmless : float
            Set-point after a reset, degrees Celsius.
        ramp : float
            How long the ramp takes, s.

        Raises
        ------
        OvenError
            Of kind not taken, if the program does not run or a register reads back different; of another kind if
            the line fails.
        """
        self.expiry.starting = True
        put = self._unit.put
        put(SELECTED, 0, name="set-point select")
        put(LOCAL, here, self._decimals, name="set-point 1")
        put(STATUS, RESET, name="program status")
        put(NUMBER, self._number, name="program number")
        put(MODE, AUTOMATIC, name="auto/manual")
        self._unit.write(STATUS, RUN)
        status = self._unit.read(STATUS)
        put(LOCAL, harmless, self._decimals, name="set-point 1")
        if status not in (RUN, COMPLETE):
            raise OvenError(
                Fault.NOT_TAKEN,
                f"program {self._number} was started and its status reads back {status:g}",
                WITHOUT,
            )
        self.expiry.begin(self._unit.line.now, ramp)

    def send_reset(self) -> None:
        """Command its stop, without reading anything."""
        self._unit.write(STATUS, RESET)

    def reset(self) -> None:
        """Stop it: in automatic, the instrument goes to set-point 1."""
        self.expiry.end()
        with of(f"program {self._number}", WITHOUT):
            self._unit.put(STATUS, RESET, name="program status")
