"""What a simulated controller is to the wire, and a wire inside the process.

To the wire it is bytes in, bytes out, some of them late. The wire inside the process is for virtual time, and for
Windows, which has no pseudo-terminals.

The far end of Modbus RTU, written apart from the library the drivers use, so that each checks the other.

Frames and exception codes: MODBUS application protocol specification V1.1b3; CRC: MODBUS over serial
line V1.02, 6.2.2.
"""

import struct
from typing import NamedTuple, Protocol

from drivers.clock import Clock
from drivers.ovens.error import Fault, OvenError


class Delivery(NamedTuple):
    """Bytes that leave the controller `delay` seconds after the request came."""

    delay: float
    data: bytes


class Controller(Protocol):
    """The far end of a line."""

    def receive(self, data: bytes) -> list[Delivery]:
        """Take what came in, in whatever pieces, and return what goes out."""
        ...


class LineController:
    """Text controllers: a command ends with a terminator, and so does each answer.

    Parameters
    ----------
    terminator : bytes
    """

    def __init__(self, terminator: bytes) -> None:
        self._terminator = terminator
        self._received = b""

    def receive(self, data: bytes) -> list[Delivery]:
        """Answer every whole command, keep the rest."""
        *commands, self._received = (self._received + data).split(self._terminator)
        answers = [self.answer(command.decode("latin-1")) for command in commands]
        return [Delivery(0.0, answer.encode("latin-1") + self._terminator) for answer in answers if answer]

    def answer(self, command: str) -> str:
        """Return the answer to one command; an empty one for silence."""
        raise NotImplementedError


class MemoryTransport:
    """Hands each write to a controller and keeps what it answers until it is due.

    Parameters
    ----------
    controller : Controller
    clock : Clock
        Waiting for an answer moves it on.

    Attributes
    ----------
    plugged : bool
        False is a pulled cable: every use raises.
    """

    def __init__(self, controller: Controller, clock: Clock) -> None:
        self._controller = controller
        self._clock = clock
        self._coming: list[tuple[float, bytes]] = []
        self._closed = False
        self.plugged = True

    def write(self, data: bytes) -> None:
        """Hand `data` over and note what comes back when."""
        self._check()
        now = self._clock.now()
        self._coming += [(now + delay, answer) for delay, answer in self._controller.receive(data)]
        self._coming.sort(key=lambda coming: coming[0])

    def read(self, wait: float) -> bytes:
        """Return what is due first, if it is due within `wait` s."""
        self._check()
        now = self._clock.now()
        if not self._coming or self._coming[0][0] > now + wait:
            self._clock.sleep(wait)
            return b""
        due, data = self._coming.pop(0)
        self._clock.sleep(due - now)
        return data

    def drain(self) -> None:
        """Forget what is due."""
        self._check()
        now = self._clock.now()
        self._coming = [coming for coming in self._coming if coming[0] > now]

    def close(self) -> None:
        """Refuse any further use."""
        self._closed = True

    def _check(self) -> None:
        if self._closed:
            raise OvenError(Fault.PORT, "the simulated line was closed", "Open the oven again.")
        if not self.plugged:
            raise OvenError(Fault.PORT, "the simulated cable is unplugged", "Plug it in again.")


READ_COIL, READ_DISCRETE, READ, READ_INPUT, WRITE_COIL, WRITE_ONE, WRITE_MANY = 1, 2, 3, 4, 5, 6, 16
COIL_ON = 0xFF00
ILLEGAL_FUNCTION, ILLEGAL_ADDRESS, ILLEGAL_VALUE = 1, 2, 3


def crc16(frame: bytes) -> bytes:
    """Return the checksum that follows `frame`, low byte first."""
    register = 0xFFFF
    for byte in frame:
        register ^= byte
        for _ in range(8):
            register = (register >> 1) ^ 0xA001 if register & 1 else register >> 1
    return register.to_bytes(2, "little")


class ModbusServer:
    """Serves one unit's registers; silent to other units and to damaged frames, as a real one is.

    Parameters
    ----------
    address : int
        1 to 247.
    """

    def __init__(self, address: int) -> None:
        self._address = address
        self._received = b""

    def receive(self, data: bytes) -> list[Delivery]:
        """Answer every whole frame, keep the rest."""
        self._received += data
        answers = []
        while (length := self._due()) is not None and len(self._received) >= length:
            frame, self._received = self._received[:length], self._received[length:]
            if crc16(frame[:-2]) != frame[-2:]:
                self._received = b""  # out of step: a real unit waits for the next pause
            elif frame[0] == self._address:
                body = bytes([self._address]) + self._answer(frame[1], frame[2:-2])
                answers.append(Delivery(0.0, body + crc16(body)))
        return answers

    def read_word(self, register: int) -> int:
        """Return a register, 0 to 65535; LookupError if there is none."""
        raise NotImplementedError

    def read_input(self, register: int) -> int:
        """Return an input register, 0 to 65535; LookupError if there is none."""
        raise NotImplementedError

    def read_bit(self, register: int, function: int) -> int:
        """Return a coil (function 1) or discrete input (2), 0 or 1; LookupError if there is none."""
        raise NotImplementedError

    def write_bit(self, register: int, bit: int) -> None:
        """Store a coil; LookupError if there is none."""
        raise NotImplementedError

    def write_words(self, register: int, words: tuple[int, ...]) -> None:
        """Store registers; LookupError if there are none, ValueError if they do not take the value."""
        raise NotImplementedError

    def _due(self) -> int | None:
        if len(self._received) < 7:
            return None
        return 9 + self._received[6] if self._received[1] == WRITE_MANY else 8

    def _answer(self, function: int, body: bytes) -> bytes:
        start, second = struct.unpack(">HH", body[:4])
        try:
            if function in (READ, READ_INPUT):
                read = self.read_word if function == READ else self.read_input
                words = [read(start + i) for i in range(second)]
                return struct.pack(f">BB{second}H", function, 2 * second, *words)
            if function in (READ_COIL, READ_DISCRETE) and second == 1:
                return bytes([function, 1, self.read_bit(start, function)])
            if function == WRITE_COIL:
                self.write_bit(start, int(second == COIL_ON))
            elif function == WRITE_ONE:
                self.write_words(start, (second,))
            elif function == WRITE_MANY:
                self.write_words(start, struct.unpack(f">{second}H", body[5:]))
            else:
                return bytes([function | 0x80, ILLEGAL_FUNCTION])
        except NotImplementedError:  # of a unit without such a table
            return bytes([function | 0x80, ILLEGAL_FUNCTION])
        except LookupError:
            return bytes([function | 0x80, ILLEGAL_ADDRESS])
        except ValueError:
            return bytes([function | 0x80, ILLEGAL_VALUE])
        return bytes([function]) + body[:4]


def float_words(value: float, *, low_first: bool) -> tuple[int, int]:
    """Return the two registers of an IEEE 754 single."""
    high, low = struct.unpack(">HH", struct.pack(">f", value))
    return (low, high) if low_first else (high, low)


def words_float(words: tuple[int, ...], *, low_first: bool) -> float:
    """Return the IEEE 754 single in two registers; ValueError for any other number of them."""
    if len(words) != 2:
        raise ValueError(f"{len(words)} registers are no float")
    high, low = words[::-1] if low_first else words
    value: float = struct.unpack(">f", struct.pack(">HH", high, low))[0]
    return value


class ModbusTcp:
    """The same unit behind a port of its own: Modbus messaging on TCP/IP, V1.0b.

    Parameters
    ----------
    server : ModbusServer
    """

    def __init__(self, server: ModbusServer) -> None:
        self.server = server
        self._received = b""

    def receive(self, data: bytes) -> list[Delivery]:
        """Answer every whole frame in its envelope, keep the rest."""
        self._received += data
        answers: list[Delivery] = []
        while len(self._received) >= 6:
            length = 6 + int.from_bytes(self._received[4:6], "big")
            if len(self._received) < length:
                break
            envelope, body = self._received[:4], self._received[6:length]
            self._received = self._received[length:]
            for delay, frame in self.server.receive(body + crc16(body)):
                answers.append(Delivery(delay, envelope + struct.pack(">H", len(frame) - 2) + frame[:-2]))
        return answers
