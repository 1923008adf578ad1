"""How an instrument on a serial line or a TCP port is reached: keys that all such kinds share."""

import re
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, model_validator

from analysis.declaration.strict import Declared
from drivers.clock import Clock
from drivers.ovens.line import Line, Timing, Transport
from drivers.ovens.serial_port import SerialPort

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
