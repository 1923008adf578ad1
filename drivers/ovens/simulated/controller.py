"""What a simulated controller is to the wire, and a wire inside the process.

To the wire it is bytes in, bytes out, some of them late. The wire inside the process is for virtual time, and for
Windows, which has no pseudo-terminals.
"""

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
