"""The whole lines that were added to a growing text file since one looked last."""

from pathlib import Path


class Tail:
    """Follows a file that another process appends to.

    Parameters
    ----------
    path : Path
        Need not be there yet.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._read = 0

    def lines(self) -> list[str]:
        """Return what is new; a last line without its end is left for the next time."""
        try:
            with self._path.open("rb") as file:
                file.seek(self._read)
                new = file.read()
        except OSError:  # not there yet, or for a moment out of reach
            return []
        whole = new.rfind(b"\n") + 1
        self._read += whole
        return new[:whole].decode("utf-8", errors="replace").splitlines()
