"""How an instrument on a serial line or a TCP port is reached: keys of all such kinds, and the ports opened."""

import os
import re
from typing import Annotated, ClassVar, Literal, Self

import serial
from pydantic import Field, model_validator

from analysis.declaration.strict import Declared
from drivers.clock import Clock
from drivers.ovens.error import Fault, OvenError
from drivers.ovens.line import Line, Timing, Transport

_GATEWAY = re.compile(r"socket://(\[[0-9A-Fa-f:.]+\]|[A-Za-z0-9.-]+):[0-9]{1,5}")
"""Others of pyserial's addresses write files (spy://), or take options that do."""


class LineSettings(Declared):
    """A port, its baud rate and frame, time-outs and pauses."""

    gaps: ClassVar[tuple[float, float]] = (0.02, 0.1)
    """Seconds of silence the kind wants after a question and after a command."""

    port: Annotated[
        str,
        Field(
            min_length=1,
            max_length=255,
            description="serial port (COM3, /dev/ttyUSB0) or socket://host:port of a gateway",
        ),
    ]
    baud_rate: Annotated[int, Field(ge=300, le=921_600, description="bit/s")] = 9600
    parity: Annotated[Literal["N", "E", "O"], Field(description="none, even or odd")] = "N"
    stop_bits: Annotated[Literal[1, 2], Field(description="per character")] = 1
    timeout: Annotated[float, Field(ge=0.02, le=30.0, description="s, for one whole answer")] = 1.0
    retries: Annotated[int, Field(ge=0, le=10, description="further attempts after a failed one")] = 2
    gap_after_read: Annotated[
        float | None,
        Field(ge=0.0, le=10.0, description="s of silence after a query; default: that of the kind"),
    ] = None
    gap_after_write: Annotated[
        float | None,
        Field(ge=0.0, le=10.0, description="s of silence after a command; default: that of the kind"),
    ] = None
    lost_after: Annotated[
        float,
        Field(ge=1.0, le=3600.0, description="s without a usable answer after which it counts as lost"),
    ] = 60.0

    @model_validator(mode="after")
    def _reachable(self) -> Self:
        self.timing()
        if not self.port.isprintable() or ("://" in self.port and not _GATEWAY.fullmatch(self.port)):
            raise ValueError(
                f"port {self.port!r}: a serial port's name (COM3, /dev/ttyUSB0) or socket://HOST:PORT allowed, "
                "and no other address"
            )
        return self

    @property
    def place(self) -> str:
        """The port."""
        return self.port

    def timing(self) -> Timing:
        """Return how patient the line is."""
        after_read, after_write = self.gaps
        return Timing(
            timeout=self.timeout,
            retries=self.retries,
            gap_after_read=after_read if self.gap_after_read is None else self.gap_after_read,
            gap_after_write=after_write if self.gap_after_write is None else self.gap_after_write,
            lost_after=self.lost_after,
        )

    def line(self, clock: Clock, transport: Transport | None = None) -> Line:
        """Open the port, or take `transport` in its place; OvenError of kind port where it cannot be opened."""
        transport = transport or SerialPort(self.port, self.baud_rate, self.parity, self.stop_bits)
        return Line(transport, clock, self.timing())


MOST = 10_000
"""Largest number of reads that discard unexpected data before the next query is sent."""


class SerialPort:
    """A port that opens again by itself after the cable was pulled.

    Parameters
    ----------
    address : str
        ``COM3``, ``/dev/ttyUSB0``, a pseudo-terminal, or ``socket://host:port``.
    baud_rate : int
    parity : str
        ``N``, ``E`` or ``O``.
    stop_bits : int

    Raises
    ------
    OvenError
        Of kind port, if it cannot be opened.
    """

    def __init__(self, address: str, baud_rate: int = 9600, parity: str = "N", stop_bits: int = 1) -> None:
        self._address = address
        self._baud_rate, self._parity, self._stop_bits = baud_rate, parity, stop_bits
        self._open: serial.Serial | None = None
        self._closed = False
        self._port()

    def write(self, data: bytes) -> None:
        """Send all of `data`."""
        try:
            self._port().write(data)
        except OSError as error:
            raise self._gone(error) from error

    def read(self, wait: float) -> bytes:
        """Return what comes within `wait` s; empty after silence."""
        try:
            port = self._port()
            if port.timeout != wait:
                port.timeout = wait
            first: bytes = port.read(1)
            return first + port.read(port.in_waiting) if first else b""
        except OSError as error:
            raise self._gone(error) from error

    def drain(self) -> None:
        """Throw away what has come unread."""
        # reset_input_buffer would do, but raises termios.error, which Windows does not know, once a
        # USB adapter has been pulled.
        try:
            port = self._port()
            port.timeout = 0.0
            for _ in range(MOST):  # bounded, because the other end may send without end
                if not (port.in_waiting and port.read(port.in_waiting)):
                    break
        except OSError as error:
            raise self._gone(error) from error

    def close(self) -> None:
        """Close for good."""
        self._closed = True
        self._let_go()

    def _port(self) -> serial.Serial:
        if self._closed:
            raise OvenError(Fault.PORT, f"{self._address} was closed", "Open the oven again.")
        if self._open is None:
            try:
                self._open = serial.serial_for_url(
                    self._address,
                    baudrate=self._baud_rate,
                    parity=self._parity,
                    stopbits=self._stop_bits,
                    timeout=0.0,
                    write_timeout=2.0,
                    exclusive=True,
                )
            except (OSError, ValueError) as error:
                raise OvenError(
                    Fault.PORT,
                    f"{self._address} cannot be opened: {_said(error)}",
                    "Check the port's name, the cable, the right to use it, and that no other program has it.",
                ) from error
        return self._open

    def _gone(self, error: OSError) -> OvenError:
        self._let_go()
        return OvenError(
            Fault.PORT, f"{self._address} failed: {error}", "Plug the cable or adapter in again; check its power."
        )

    def _let_go(self) -> None:
        port, self._open = self._open, None
        if port is not None:
            try:
                port.close()
            except OSError:
                return  # already gone, which is what was wanted


def _said(error: Exception) -> str:
    """Say what the system said, once: pyserial puts its number and the port before and behind it."""
    number = getattr(error, "errno", None)
    return os.strerror(number).lower() if number else str(error)
