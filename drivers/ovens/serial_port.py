"""Serial ports, pseudo-terminals and TCP sockets, all through pyserial."""

import os

import serial

from drivers.ovens.error import Fault, OvenError

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
