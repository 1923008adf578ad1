"""A line inside the process: for virtual time, and for Windows, which has no pseudo-terminals."""

from drivers.clock import Clock
from drivers.ovens.error import Fault, OvenError
from drivers.ovens.simulated.controller import Controller


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
