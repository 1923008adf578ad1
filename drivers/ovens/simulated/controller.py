"""What a simulated controller is to the wire: bytes in, bytes out, some of them late."""

from typing import NamedTuple, Protocol


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
