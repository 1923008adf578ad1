"""What goes wrong with a file of results."""

from app.files.misplaced import Misplaced


class ResultFileError(ValueError):
    """A result file is missing, of another kind, or damaged; the message says which and what to do.

    Attributes
    ----------
    misplaced : Misplaced, optional
        The geometry declared, where that is wrong.
    """

    def __init__(self, message: str, misplaced: Misplaced | None = None) -> None:
        super().__init__(message)
        self.misplaced = misplaced


class UnsuitedOptionError(ResultFileError):
    """An option does not suit the files that are there: what was typed is wrong, not a file."""
