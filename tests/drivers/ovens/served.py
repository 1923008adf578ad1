"""Simulated controllers at a real port: a pseudo-terminal (POSIX) or a TCP port of this machine.

Both carry the drivers' bytes through pyserial exactly as a cable would.

What happens to answers on a bad line: each disturbance turns one answer into what arrives of it.
"""

import heapq
import os
import select
import socket
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable
from functools import partial
from types import TracebackType
from typing import Self

from drivers.ovens.simulated.controller import Controller, Delivery, crc16

TICK = 0.02
"""Seconds between two looks at whether to stop."""


class _Served:
    """A thread that carries bytes between a file descriptor and a controller until it is left."""

    address: str

    def __init__(self) -> None:
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="simulated oven", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stop.set()
        self._thread.join()
        self._close()

    def _run(self) -> None:
        raise NotImplementedError

    def _close(self) -> None:
        raise NotImplementedError

    def _carry(
        self,
        end: int | socket.socket,
        receive: Callable[[], bytes],
        send: Callable[[bytes], object],
        to: Controller,
    ) -> None:
        due: list[tuple[float, int, bytes]] = []
        count = 0
        while not self._stop.is_set():
            now = time.monotonic()
            while due and due[0][0] <= now:
                send(heapq.heappop(due)[2])
            wait = min(TICK, due[0][0] - now) if due else TICK
            if select.select([end], [], [], wait)[0]:
                data = receive()
                if not data:
                    return
                for delay, answer in to.receive(data):
                    count += 1  # keeps answers due at the same time in their order
                    heapq.heappush(due, (time.monotonic() + delay, count, answer))


def _pseudo_terminal() -> tuple[int, int, str]:
    """Return both ends of one, and the name to open the near end by."""
    if sys.platform == "win32":
        raise OSError("pseudo-terminals need a POSIX system: serve the controller on a TCP port instead")
    else:
        import tty

        far, near = os.openpty()
        tty.setraw(near)
        return far, near, os.ttyname(near)


class PtyPort(_Served):
    """A controller at a pseudo-terminal; `address` is what to open.

    Raises
    ------
    OSError
        On Windows, which has none: use `TcpPort` or `MemoryTransport`.
    """

    def __init__(self, controller: Controller) -> None:
        super().__init__()
        self._controller = controller
        self._far, self._near, self.address = _pseudo_terminal()

    def _run(self) -> None:
        # The near end stays open here, so that a driver may close and open it again.
        self._carry(
            self._far,
            lambda: os.read(self._far, 4096),
            lambda data: os.write(self._far, data),
            self._controller,
        )

    def _close(self) -> None:
        os.close(self._near)
        os.close(self._far)


class TcpPort(_Served):
    """A controller at a port of this machine, for one client at a time; `address` is what to open.

    Parameters
    ----------
    controller : Controller
    port : int
        0 for any that is free.
    """

    def __init__(self, controller: Controller, port: int = 0) -> None:
        super().__init__()
        self._controller = controller
        self._server = socket.create_server(("127.0.0.1", port))
        self._server.settimeout(TICK)
        self.address = f"socket://127.0.0.1:{self._server.getsockname()[1]}"

    def _run(self) -> None:
        while not self._stop.is_set():
            try:
                client, _ = self._server.accept()
            except TimeoutError:
                continue
            with client:
                try:
                    self._carry(client, partial(client.recv, 4096), client.sendall, self._controller)
                except ConnectionError:
                    continue  # the client has gone: wait for the next

    def _close(self) -> None:
        self._server.close()


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
