"""What can go wrong between the computer and the oven, and what to do next."""

from enum import StrEnum
from typing import ClassVar


class Fault(StrEnum):
    """Kinds of trouble, by what a caller can do about them."""

    SILENT = "silent"
    """No answer within the time-out."""
    GARBLED = "garbled"
    """An answer that is not one: checksum, unit, length or wording are wrong."""
    BUSY = "busy"
    """The controller cannot answer now, or a gateway does not reach it: ask again."""
    REFUSED = "refused"
    """The controller understood and said no."""
    NOT_TAKEN = "not taken"
    """The controller said yes, and reads back something else."""
    ALARM = "alarm"
    """The oven reports trouble of its own, or has stopped by itself."""
    PORT = "port"
    """The port cannot be opened, or has gone."""
    LOST = "lost"
    """No usable answer for longer than the limit: stop the campaign."""


class OvenError(Exception):
    """Trouble with the oven.

    Attributes
    ----------
    fault : Fault
        Kind of trouble.
    what : str
        What happened, with the values seen.
    advice : str
        What to do next.
    code : str or None
        The controller's own code or words, where it gave any.
    """

    instrument: ClassVar[str] = "oven"

    def __init__(self, fault: Fault, what: str, advice: str, code: str | None = None) -> None:
        self.fault = fault
        self.what = what
        self.advice = advice
        self.code = code
        super().__init__(fault, what, advice, code)

    def __str__(self) -> str:
        said = f" (the controller says {self.code})" if self.code else ""
        return f"{self.instrument} {self.fault}: {self.what}{said}. {self.advice}"
