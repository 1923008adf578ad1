"""The echo of a line: an adapter that receives its own transmission returns every request before the answer.

Two-wire RS-485 adapters do so unless their receiver is switched off while they send. The echo is recognised by its
bytes, which are those of the request.
"""


class Echo:
    """What one line is known to return of its requests.

    Attributes
    ----------
    present : bool or None
        Whether it returns them; None as long as no exchange has shown it.
    """

    def __init__(self) -> None:
        self.present: bool | None = None

    def answer(self, request: bytes, received: bytes, *, repeats: bool) -> bytes | None:
        """Return what was received without the echo before it; None while that cannot be told.

        On a line of which nothing is known yet, an answer that may be equal to its request, as that to a Modbus
        command of one register is, is told from an echo only by a second copy.

        Parameters
        ----------
        repeats : bool
            Whether a sound answer may be equal to the request.
        """
        if len(received) < len(request) and request.startswith(received):
            return None
        if not received.startswith(request):
            return received
        after = received[len(request) :]
        if not repeats:
            self.present = True
        elif self.present is None:
            if len(after) < len(request) and request.startswith(after):
                return None
            self.present = True if after.startswith(request) else None
        elif not self.present:
            return received
        return after

    def learn(self, request: bytes, received: bytes) -> None:
        """Note of a whole answer to `request` whether an echo came before it."""
        self.present = received.startswith(request)

    def at_the_end(self, request: bytes, received: bytes, *, repeats: bool) -> bytes:
        """Return the answer as `answer` does, when the time is over and nothing more is to come.

        Parameters
        ----------
        repeats : bool
            Whether a sound answer may be equal to the request.

        Returns
        -------
        bytes
            A single copy of a request that may be its own answer is taken for it: what it has done is read back.
        """
        answer = self.answer(request, received, repeats=repeats)
        return received if answer is None else answer
