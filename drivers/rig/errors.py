"""Why a campaign stopped before its end."""

RESUME = "Then run the same command again: what is finished stays"


class RigStopped(Exception):  # noqa: N818 (not an error of the program)
    """The campaign cannot continue now; the same command resumes it.

    Attributes
    ----------
    what : str
        What happened, with the values seen.
    next_step : str
        What the user can do about it.
    """

    def __init__(self, what: str, next_step: str) -> None:
        self.what = what
        self.next_step = next_step
        super().__init__(what, next_step)

    def __str__(self) -> str:
        return f"{self.what.rstrip('.')}. {self.next_step.rstrip('.')}."


class RigInterrupted(KeyboardInterrupt):
    """The user ended the program; the same command resumes the campaign."""
