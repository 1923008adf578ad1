"""Protocol of the storage of a hammer test; `app` implements it with files."""

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from drivers.hammer.judged_hit import HitTemperature, JudgedHit
from drivers.hammer.progress import HammerProgress, KeptHit


class HammerStore(Protocol):
    """Stores hits and the log. All methods may raise OSError: a full or failing disk."""

    def kept(self) -> Sequence[KeptHit]:
        """Return the accepted hits that are there, whole, undone ones too."""
        ...

    def measured(self, hit: KeptHit) -> JudgedHit:
        """Read a hit, and judge it again."""
        ...

    def keep(self, hit: JudgedHit, kept: KeptHit, temperature: HitTemperature, date: str) -> None:
        """Store an accepted hit permanently; return when it is on the disk.

        Parameters
        ----------
        temperature : HitTemperature
            Of the plate.
        date : str
            ISO 8601.
        """
        ...

    def put_aside(self, hit: JudgedHit, kept: KeptHit, temperature: HitTemperature, date: str) -> None:
        """Store a rejected hit apart from the accepted ones."""
        ...

    def declare(self, progress: HammerProgress) -> None:
        """Write the declarations with which other verbs read the hits that count."""
        ...

    def log(self, event: Mapping[str, Any]) -> None:
        """Append an event; return when it is on the disk."""
        ...

    def events(self) -> Sequence[Mapping[str, Any]]:
        """Return every event so far, oldest first."""
        ...
