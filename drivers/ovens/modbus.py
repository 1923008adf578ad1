"""Registers of a Modbus unit: read, written, read back, in frames of Modbus RTU and TCP.

A line carries the frames; minimalmodbus makes and checks them.
"""

import struct
from collections.abc import Callable, Sequence
from typing import Literal, TypeVar

import minimalmodbus

from drivers.ovens.error import Fault, OvenError
from drivers.ovens.line import Line

T = TypeVar("T")
WordOrder = Literal["high word first", "low word first"]

PERMANENT = frozenset({1, 2, 3, 7})
"""Exception codes of a request that this unit never takes: function, address or value. Any other may pass: 4, 5, 6
and 8 of a unit that is not able now; 10 and 11 of a gateway that did not reach the unit in time, which is the same
as its silence."""
GATEWAY = frozenset({10, 11})

_ORDER = {
    "high word first": minimalmodbus.BYTEORDER_BIG,
    "low word first": minimalmodbus.BYTEORDER_LITTLE_SWAP,
}


Framing = Literal["rtu", "tcp"]

REPEATED = frozenset({5, 6})
"""Functions whose sound answer is equal to the request: one coil, one register."""


class ModbusExceptionAnswer(minimalmodbus.SlaveReportedException):
    """An exception that a unit, or a gateway before it, answers with.

    Minimalmodbus has no classes for those of gateways, and takes number 5 for a damaged answer.

    Attributes
    ----------
    number : int
        Exception code, 1 to 255.
    """

    def __init__(self, number: int) -> None:
        super().__init__(f"exception {number}, {MEANINGS.get(number, 'a meaning of the maker')}")
        self.number = number


MEANINGS = {
    1: "illegal function",
    2: "illegal data address",
    3: "illegal data value",
    4: "device failure",
    5: "acknowledge, in progress",
    6: "device busy",
    7: "negative acknowledge",
    8: "memory parity error",
    10: "gateway path unavailable",
    11: "gateway target device failed to respond",
}
"""MODBUS application protocol specification V1.1b3, section 7."""


def crc16(frame: bytes) -> bytes:
    """Return the checksum that follows `frame`, low byte first."""
    register = 0xFFFF
    for byte in frame:
        register ^= byte
        for _ in range(8):
            register = (register >> 1) ^ 0xA001 if register & 1 else register >> 1
    return register.to_bytes(2, "little")


class _OpenPort:
    """Stands in for the open serial port that minimalmodbus requires; never used."""

    is_open = True
    open = close = read = write = None


class FramedInstrument(minimalmodbus.Instrument):
    """Minimalmodbus with the line in the place of its serial port.

    It can be handed a port-like object as well, but then keeps its own pause between frames, by the
    wall clock: 2 ms for each exchange that takes no time at all on a virtual clock. The line has gaps.

    Modbus TCP is the same in another envelope: a number that the answer repeats, and no checksum, which TCP has.
    """

    def __init__(self, line: Line, address: int, framing: Framing = "rtu") -> None:
        super().__init__(_OpenPort(), address)  # type: ignore[arg-type]
        self._line = line
        self._framing = framing
        self._number = 0

    def _communicate(self, request: bytes, number_of_bytes_to_read: int) -> bytes:
        tcp = self._framing == "tcp"
        answer = self._tcp(request) if tcp else self._rtu(request, number_of_bytes_to_read)
        told = len(answer) == 5 and answer[:2] == bytes([request[0], request[1] | 0x80])
        if told and crc16(answer[:3]) == answer[3:]:
            raise ModbusExceptionAnswer(answer[2])
        return answer

    def _tcp(self, request: bytes) -> bytes:
        self._number = self._number % 0xFFFF + 1
        envelope = struct.pack(">HHH", self._number, 0, len(request) - 2)

        def end(received: bytes) -> int | None:
            due = 6 + int.from_bytes(received[4:6], "big") if len(received) >= 6 else 6 + 3
            return due if len(received) >= due else None

        answer = self._line.exchange(envelope + request[:-2], end, repeats=request[1] in REPEATED)
        if not answer:
            raise minimalmodbus.NoResponseError("no answer")
        if len(answer) < 9 or answer[:4] != envelope[:4] or len(answer) != 6 + int.from_bytes(answer[4:6], "big"):
            raise minimalmodbus.InvalidResponseError(f"{answer[:12]!r} is no answer to question {self._number}")
        return answer[6:] + crc16(answer[6:])

    def _rtu(self, request: bytes, number_of_bytes_to_read: int) -> bytes:
        def end(received: bytes) -> int | None:
            # an exception is five bytes long, whatever was asked for
            due = 5 if len(received) > 1 and received[1] & 0x80 else number_of_bytes_to_read
            return due if len(received) >= due else None

        answer = self._line.exchange(request, end, repeats=request[1] in REPEATED)
        if not answer:
            raise minimalmodbus.NoResponseError("no answer")
        return answer


class ModbusUnit:
    """The registers of one unit on a line.

    Parameters
    ----------
    line : Line
    address : int
        1 to 247.
    word_order : str
        Of its 32-bit floats.
    framing : str
        ``rtu``, on a serial line or through a gateway; ``tcp`` for Modbus TCP.
    """

    def __init__(
        self,
        line: Line,
        address: int,
        word_order: WordOrder = "high word first",
        framing: Framing = "rtu",
    ) -> None:
        self.line = line
        self._address = address
        self._order = _ORDER[word_order]
        self._unit = FramedInstrument(line, address, framing)

    def read(self, register: int, decimals: int = 0, *, signed: bool = True) -> float:
        """Return one register as a scaled integer.

        Parameters
        ----------
        decimals : int
            The content is divided by 10 to this power.

        Returns
        -------
        float
            In the register's unit.
        """
        return self._call(lambda: float(self._unit.read_register(register, decimals, signed=signed)))

    def write(self, register: int, value: float, decimals: int = 0, *, signed: bool = True) -> None:
        """Write one register (function 6) as a scaled integer.

        Parameters
        ----------
        value : float
            In the register's unit.
        decimals : int
            The value is multiplied by 10 to this power, and rounded.
        """
        # minimalmodbus scales and then cuts off: 0.29 with two decimals would become 28
        scaled = round(value * 10**decimals)
        self._call(lambda: self._unit.write_register(register, scaled, functioncode=6, signed=signed), writes=True)

    def read_float(self, register: int) -> float:
        """Return two registers as an IEEE 754 single, to the seven digits it holds."""
        return self._call(lambda: float(f"{self._unit.read_float(register, byteorder=self._order):.7g}"))

    def write_float(self, register: int, value: float) -> None:
        """Write two registers (function 16) as an IEEE 754 single."""
        self._call(lambda: self._unit.write_float(register, value, byteorder=self._order), writes=True)

    def read_words(self, register: int, count: int, function: int) -> tuple[int, ...]:
        """Return registers as they are.

        Parameters
        ----------
        register : int
            The first.
        function : int
            3 for holding registers, 4 for inputs.

        Returns
        -------
        (count,) tuple of int
            0 to 65535 each.
        """
        return tuple(self._call(lambda: self._unit.read_registers(register, count, functioncode=function)))

    def write_words(self, register: int, words: Sequence[int]) -> None:
        """Write holding registers: one by function 6, several by 16."""
        if len(words) == 1:
            self._call(lambda: self._unit.write_register(register, words[0], functioncode=6), writes=True)
        else:
            self._call(lambda: self._unit.write_registers(register, [*words]), writes=True)

    def read_bit(self, register: int, function: int) -> int:
        """Return a coil (function 1) or a discrete input (2), 0 or 1."""
        return int(self._call(lambda: self._unit.read_bit(register, functioncode=function)))

    def write_bit(self, register: int, bit: int) -> None:
        """Write a coil (function 5)."""
        self._call(lambda: self._unit.write_bit(register, bit, functioncode=5), writes=True)

    def put(self, register: int, value: float, decimals: int = 0, *, name: str) -> float:
        """Make a register hold `value`, and read it back.

        A register that holds it already is not written: many controllers keep their settings in a
        memory that wears out.

        Parameters
        ----------
        value : float
            In the register's unit.
        decimals : int
            As of `write`.
        name : str
            What the register is, for messages.

        Returns
        -------
        float
            What it holds, in the register's unit.

        Raises
        ------
        OvenError
            Of kind not taken, if it reads back different.
        """
        tolerance = 0.5001 * 10.0**-decimals
        with self.line.reserved():
            held = self.read(register, decimals)
            if abs(held - value) > tolerance:
                self.write(register, value, decimals)
                held = self.read(register, decimals)
        return _taken(name, register, value, held, tolerance)

    def put_float(self, register: int, value: float, tolerance: float, *, name: str) -> float:
        """Make two registers hold a 32-bit float; otherwise as `put`.

        Parameters
        ----------
        register : int
            The first of the two.
        value, tolerance : float
            In the register's unit; what differs by no more than `tolerance` is not written, and is taken.

        Returns
        -------
        float
            What they hold.
        """
        with self.line.reserved():
            held = self.read_float(register)
            if not abs(held - value) <= tolerance:  # so that NaN is written over
                self.write_float(register, value)
                held = self.read_float(register)
        return _taken(name, register, value, held, tolerance)

    def put_long(self, register: int, value: int, *, name: str) -> int:
        """Make two registers, high word first, hold a whole number; otherwise as `put`.

        Parameters
        ----------
        register : int
            The first of the two.

        Returns
        -------
        int
            What they hold.
        """
        with self.line.reserved():
            held = self._call(lambda: int(self._unit.read_long(register)))
            if held != value:
                self._call(lambda: self._unit.write_long(register, value), writes=True)
                held = self._call(lambda: int(self._unit.read_long(register)))
        return int(_taken(name, register, value, held, 0.0))

    def _call(self, action: Callable[[], T], *, writes: bool = False) -> T:
        return self.line.attempt(lambda: self._translated(action), writes=writes)

    def _translated(self, action: Callable[[], T]) -> T:
        try:
            return action()
        except minimalmodbus.NoResponseError as error:
            raise OvenError(
                Fault.SILENT,
                f"Modbus unit {self._address} does not answer",
                "Is it switched on and wired (A and B may be swapped)? Check address, baud rate and parity.",
            ) from error
        except ModbusExceptionAnswer as error:
            raise self._told(error) from error
        except minimalmodbus.MasterReportedException as error:
            if "slave address" in str(error):
                raise OvenError(
                    Fault.GARBLED,
                    f"another unit answers instead of unit {self._address}: {error}",
                    "Give every unit on the line an address of its own, and check address.",
                ) from error
            raise OvenError(
                Fault.GARBLED,
                f"damaged answer: {error}",
                "Check baud rate and parity, the cable's shield and ground, and the distance to power lines.",
            ) from error

    def _told(self, answer: ModbusExceptionAnswer) -> OvenError:
        unit = f"Modbus unit {self._address}"
        if answer.number in PERMANENT:
            return OvenError(
                Fault.REFUSED,
                f"{unit} refuses the request",
                "Check that kind names the model on the label, and that the value is within its own limits.",
                str(answer),
            )
        if answer.number in GATEWAY:
            return OvenError(
                Fault.BUSY,
                f"the gateway does not reach {unit}",
                "Is the controller switched on and wired to the gateway? Check address, and baud rate, "
                "parity and time-out of the gateway.",
                str(answer),
            )
        return OvenError(
            Fault.BUSY,
            f"{unit} cannot answer now",
            "Wait, or raise retries; look at the controller's panel if it lasts.",
            str(answer),
        )


def _taken(name: str, register: int, wanted: float, held: float, tolerance: float) -> float:
    if not abs(held - wanted) <= tolerance:  # so that NaN counts as not taken
        raise OvenError(
            Fault.NOT_TAKEN,
            f"{name} (register {register}) was set to {wanted:g} and reads back {held:g}",
            "Check the controller's own limits, its keyboard lock, and whether somebody uses its front panel.",
        )
    return held
