"""What of a hammer test is measured, undone and left out: from the hits on the disk and the log beside them.

Files are the truth of what was recorded; the log says what of it does not count any more. A hit is never deleted.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

ACCEPTED, REJECTED, UNDONE, SKIPPED = "hit", "hit rejected", "hit undone", "point skipped"
"""Events of the log. All have the number of the hit, ``step``, but for the last, which has the point."""
IN_DOUBT = "temperature in doubt"
"""Event of the station; with ``step`` where it is about a hit that was kept."""


@dataclass(frozen=True, order=True)
class KeptHit:
    """A hit on the disk that was accepted when it was made.

    Attributes
    ----------
    number : int
        Of all hits of the campaign, rejected ones too, from 0.
    set_point : int
        Temperature at which it was made, from 0; 0 of a test at one temperature.
    point : int
        That was hit, from 0.
    """

    number: int
    set_point: int
    point: int


@dataclass
class HammerProgress:
    """State of a campaign, changed hit by hit.

    Attributes
    ----------
    points : int
        That are hit at every set-point.
    wanted : int
        Hits at each.
    valid : list of KeptHit
        That count, in the order made.
    skipped : set of (int, int)
        Set-points and points that were left out.
    recorded : int
        Hits so far, rejected and undone ones too: the number of the next one.
    rejected : int
    """

    points: int
    wanted: int
    valid: list[KeptHit] = field(default_factory=list)
    skipped: set[tuple[int, int]] = field(default_factory=set)
    recorded: int = 0
    rejected: int = 0

    @classmethod
    def of(
        cls,
        points: int,
        wanted: int,
        kept: Iterable[KeptHit],
        events: Sequence[Mapping[str, Any]],
        *,
        again: bool = False,
    ) -> "HammerProgress":
        """Return the state of a campaign that may have been interrupted.

        Parameters
        ----------
        kept : iterable of KeptHit
            On the disk.
        events : sequence of mapping
            The log.
        again : bool
            Whether points that were skipped are asked for once more.
        """
        undone = {int(event["step"]) for event in events if event.get("event") == UNDONE}
        rejected = {int(event["step"]) for event in events if event.get("event") == REJECTED}
        there = sorted(kept)
        skipped = {
            (int(event["set_point"]), int(event["point"])) for event in events if event.get("event") == SKIPPED
        }
        return cls(
            points,
            wanted,
            [hit for hit in there if hit.number not in undone],
            set() if again else skipped,
            1 + max([*(hit.number for hit in there), *rejected], default=-1),
            len(rejected),
        )

    def at(self, set_point: int, point: int) -> list[KeptHit]:
        """Return the hits that count at a point."""
        return [hit for hit in self.valid if (hit.set_point, hit.point) == (set_point, point)]

    def next_point(self, set_point: int) -> int | None:
        """Return the first point that lacks hits, from 0; None where all is measured or left out."""
        for point in range(self.points):
            if (set_point, point) not in self.skipped and len(self.at(set_point, point)) < self.wanted:
                return point
        return None

    def doubted(self, events: Iterable[Mapping[str, Any]]) -> set[int]:
        """Return the numbers of the hits that count and whose temperature is in doubt, by the log."""
        told = {
            event.get("step")
            for event in events
            if (event.get("event") == ACCEPTED and event.get("doubt")) or event.get("event") == IN_DOUBT
        }
        return {hit.number for hit in self.valid} & told

    def missing(self, set_point: int) -> int:
        """Return how many hits are still wanted, those of skipped points too."""
        return sum(max(self.wanted - len(self.at(set_point, point)), 0) for point in range(self.points))
