"""What a campaign needs of whatever keeps its sweeps; files are the business of the floor above."""

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from analysis.campaign import Sweep
from analysis.protocol.set_points import SweepSetPoint
from drivers.ni.cards import Record


class Store(Protocol):
    """Keeps finished sweeps and the log. All but `show` may raise OSError: a full or failing disk."""

    def finished(self) -> frozenset[int]:
        """Return the steps whose sweeps are kept, whole and verified."""
        ...

    def keep(self, sweep: Sweep, set_point: SweepSetPoint, attempt: int) -> None:
        """Keep a good sweep for ever; return when it is on the disk.

        Parameters
        ----------
        sweep : Sweep
        set_point : SweepSetPoint
            What it was measured for.
        attempt : int
            The set-point's attempt, as counted in the log.
        """
        ...

    def put_aside(self, sweep: Sweep, set_point: SweepSetPoint, attempt: int, faults: Sequence[str]) -> None:
        """Keep a bad sweep where nobody takes it for a good one.

        Parameters
        ----------
        sweep : Sweep
        set_point : SweepSetPoint
        attempt : int
            As of `keep`.
        faults : sequence of str
            What is wrong with it.
        """
        ...

    def show(self, record: Record, set_point: SweepSetPoint, repeat: int) -> None:
        """Let people look at a repeat as soon as it is recorded; never raises, may be lost.

        Parameters
        ----------
        record : Record
        set_point : SweepSetPoint
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
