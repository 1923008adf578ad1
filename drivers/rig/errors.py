"""Why a campaign stopped before its end."""


class RigStopped(Exception):  # noqa: N818 (it is no defect of the program: the rig said stop)
    """The campaign cannot go on now; the same command takes it up again.

    Attributes
    ----------
    what : str
        What happened, with the values seen.
    next_step : str
        What a person can do about it.
    unsafe : tuple of str
        What could not be brought to rest; empty as a rule.
    """

    def __init__(self, what: str, next_step: str) -> None:
        self.what = what
        self.next_step = next_step
        self.unsafe: tuple[str, ...] = ()
        super().__init__(what, next_step)

    def __str__(self) -> str:
        unsafe = "".join(f" NOT AT REST: {what}." for what in self.unsafe)
        return f"{self.what.rstrip('.')}. {self.next_step.rstrip('.')}.{unsafe}"


class RigInterrupted(KeyboardInterrupt):
    """Somebody wants the program to end; the same command takes the campaign up again.

    Attributes
    ----------
    unsafe : tuple of str or None
        What could not be brought to rest; None where no campaign was running that could tell.
    """

    unsafe: tuple[str, ...] | None = None
