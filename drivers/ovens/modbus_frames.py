"""Frames of Modbus RTU and TCP, carried by a line: minimalmodbus makes and checks them."""

import struct
from typing import Literal

import minimalmodbus

from drivers.ovens.line import Line

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
