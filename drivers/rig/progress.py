"""Progress of a campaign, read from its log and the finished sweeps."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

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
