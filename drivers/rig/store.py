"""Protocol of the storage of a campaign; `app` implements it with files."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Protocol

from analysis.protocol.protocol import SweepSetPoint
from analysis.recordings.campaign import Sweep
from drivers.ni.cards import Record


class Store(Protocol):
    """Stores finished sweeps and the log. All methods but `show` may raise OSError: a full or failing disk."""

    def finished(self) -> frozenset[int]:
        """Return the steps whose sweeps are kept, whole and verified."""
        ...

    def sweeps(self) -> Iterator[Sweep]:
        """Read the finished sweeps, in the order in which they are asked for."""
        ...

    def keep(self, sweep: Sweep, set_point: SweepSetPoint, attempt: int) -> None:
        """Store a good sweep permanently; return when it is on the disk.

        Parameters
        ----------
        set_point : SweepSetPoint
            Set-point of the sweep.
        attempt : int
            Number of the attempt at the set-point, as in the log.
        """
        ...

    def put_aside(self, sweep: Sweep, set_point: SweepSetPoint, attempt: int, faults: Sequence[str]) -> None:
        """Store a faulty sweep apart from the good ones.

        Parameters
        ----------
        attempt : int
            As in `keep`.
        faults : sequence of str
            What is wrong with it.
        """
        ...

    def show(self, record: Record, set_point: SweepSetPoint, repeat: int) -> None:
        """Show a repeat to the user as soon as it is recorded; never raises, and the record may be lost.

        Parameters
        ----------
        repeat : int
            Counted from 0.
        """
        ...

    def log(self, event: Mapping[str, Any]) -> None:
        """Append an event; return when it is on the disk."""
        ...

    def events(self) -> Sequence[Mapping[str, Any]]:
        """Return every event so far, oldest first."""
        ...
