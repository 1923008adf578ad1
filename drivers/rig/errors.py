"""Why a campaign stopped before its end."""

RESUME = "Then run the same command again: what is finished stays"


class RigStopped(Exception):  # noqa: N818 (it is no defect of the program: the rig said stop)
    """The campaign cannot go on now; the same command takes it up again.

    Attributes
    ----------
    what : str
        What happened, with the values seen.
    next_step : str
        What a person can do about it.
    """

    def __init__(self, what: str, next_step: str) -> None:
        self.what = what
        self.next_step = next_step
        super().__init__(what, next_step)

    def __str__(self) -> str:
        return f"{self.what.rstrip('.')}. {self.next_step.rstrip('.')}."


class RigInterrupted(KeyboardInterrupt):
    """Somebody wants the program to end; the same command takes the campaign up again."""
