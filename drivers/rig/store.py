"""Storage of a campaign, which `app` implements with files, and its progress read from log and finished sweeps."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

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


Purpose = Literal["approach", "leg"]
"""Purpose of a ramp: to a leg's start, or the leg itself."""


@dataclass(frozen=True)
class Progress:
    """Progress of an interrupted campaign.

    Attributes
    ----------
    finished : frozenset of int
        Steps whose sweeps are kept.
    given_up : frozenset of int
        Steps that were missed or failed.
    attempts : dict of int to int
        Attempts made, by step.
    ramping : int or None
        The leg in whose ramp the oven was left; None if it was brought to rest, or no ramp had begun.
    begun : frozenset of int
        Legs whose ramp has begun.
    doubted : frozenset of int
        Steps whose sweeps are kept, with a temperature that is in doubt.
    """

    finished: frozenset[int]
    given_up: frozenset[int]
    attempts: dict[int, int] = field(default_factory=dict)
    ramping: int | None = None
    begun: frozenset[int] = frozenset()
    doubted: frozenset[int] = frozenset()

    @classmethod
    def of(
        cls, finished: frozenset[int], events: Sequence[Mapping[str, Any]], *, again: bool = False
    ) -> "Progress":
        """Read a log.

        Parameters
        ----------
        finished : frozenset of int
            Steps whose sweeps are kept.
        events : sequence of mapping
            Oldest first, as `Store.events` returns them.
        again : bool
            Whether to repeat what was given up: nothing counts as given up, and every leg begins at its start.
        """
        attempts: dict[int, int] = {}
        given_up: set[int] = set()
        begun: set[int] = set()
        ramping: int | None = None
        doubted: set[int] = set()
        for event in events:
            kind = event.get("event")
            if event.get("step") is not None and (kind == "temperature in doubt" or event.get("doubt")):
                doubted.add(int(event["step"]))
            if kind == "sweep begun":
                attempts[int(event["step"])] = int(event["attempt"])
            elif kind == "missing":
                given_up.add(int(event["step"]))
            elif kind == "oven":
                runs_leg = event["command"] == "ramp" and event.get("purpose") == "leg"
                ramping = int(event["leg"]) if runs_leg else None
                if runs_leg:
                    begun.add(int(event["leg"]))
        if again and given_up - finished:
            # Every leg is run from its start again, whatever the oven's state.
            return cls(finished, frozenset(), attempts, doubted=frozenset(doubted) & finished)
        return cls(
            finished,
            frozenset(given_up) - finished,
            attempts,
            ramping,
            frozenset(begun),
            frozenset(doubted) & finished,
        )
