"""What happens to answers on a bad line: each disturbance turns one answer into what arrives of it."""

from collections import deque
from collections.abc import Callable, Iterable

from drivers.ovens.simulated.controller import Controller, Delivery
from drivers.ovens.simulated.modbus_server import crc16

Disturbance = Callable[[Delivery], list[Delivery]]


def untouched(answer: Delivery) -> list[Delivery]:
    """Arrive as sent."""
    return [answer]


def silenced(answer: Delivery) -> list[Delivery]:
    """Never arrive."""
    return []


def halved(answer: Delivery) -> list[Delivery]:
    """Lose its second half."""
    return [Delivery(answer.delay, answer.data[: len(answer.data) // 2])]


def flipped(position: int) -> Disturbance:
    """Arrive with the upper bits of one byte inverted."""

    def disturb(answer: Delivery) -> list[Delivery]:
        data = bytearray(answer.data)
        data[position] ^= 0xD0
        return [Delivery(answer.delay, bytes(data))]

    return disturb


def noisy(before: bytes = b"", after: bytes = b"") -> Disturbance:
    """Insert bytes that were not sent."""
    return lambda answer: [Delivery(answer.delay, before + answer.data + after)]


def late(seconds: float) -> Disturbance:
    """Arrive `seconds` later."""
    return lambda answer: [Delivery(answer.delay + seconds, answer.data)]


def in_pieces(gap: float) -> Disturbance:
    """Arrive byte by byte, `gap` seconds apart: a slow line, but a sound one."""
    return lambda answer: [
        Delivery(answer.delay + gap * i, answer.data[i : i + 1]) for i in range(len(answer.data))
    ]


def from_unit(address: int) -> Disturbance:
    """Arrive, with a good checksum, from another Modbus unit."""

    def disturb(answer: Delivery) -> list[Delivery]:
        body = bytes([address]) + answer.data[1:-2]
        return [Delivery(answer.delay, body + crc16(body))]

    return disturb


def instead(data: bytes) -> Disturbance:
    """Give way to something else."""
    return lambda answer: [Delivery(answer.delay, data)]


class Disturbed:
    """A controller behind a bad line.

    Parameters
    ----------
    controller : Controller
    plan : iterable of Disturbance
        For the next answers, in turn; later ones arrive untouched.

    Attributes
    ----------
    always : Disturbance
        For every answer the plan does not reach.
    """

    def __init__(self, controller: Controller, plan: Iterable[Disturbance] = ()) -> None:
        self._controller = controller
        self._plan = deque(plan)
        self.always: Disturbance = untouched

    def disturb(self, *plan: Disturbance) -> None:
        """Plan disturbances for the next answers."""
        self._plan.extend(plan)

    def receive(self, data: bytes) -> list[Delivery]:
        """Pass the request on and disturb each answer."""
        deliveries = []
        for answer in self._controller.receive(data):
            disturbance = self._plan.popleft() if self._plan else self.always
            deliveries += disturbance(answer)
        return deliveries
