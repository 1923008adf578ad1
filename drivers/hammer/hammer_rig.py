"""What a hammer test needs: inputs that are read without end, whoever holds the hammer, and storage.

A trigger in software: where the force leaves a level, with the samples from before.

Both signs count: a sensor whose poles are exchanged is told at the first hit, not by a trigger that stays silent.

The level counts from where the force is at rest, the median of the last second: a sensor with a constant offset,
or one whose supply still settles, triggers where another one does.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from analysis.checked_fields import check_range
from drivers.clock import Clock
from drivers.hammer.judged_hit import HammerProgress, HitTemperature, JudgedHit, KeptHit
from drivers.ni.cards import go_on
from drivers.rig.rig import Rig


class HammerInputs(Protocol):
    """Force and responses, read block by block; see `drivers.ni.daqmx.EndlessInputs`."""

    @property
    def sample_rate(self) -> float:
        """As read back, Hz."""
        ...

    @property
    def full_scale(self) -> float:
        """Voltage beyond which the inputs clip, V."""
        ...

    def begin(self, check: Callable[[], None] = go_on) -> None:
        """Start to record."""
        ...

    def read(self, samples: int) -> NDArray[np.float64]:
        """Wait for the next samples, and return them, force first, (1 + K, samples), V."""
        ...

    def temperatures(self) -> NDArray[np.float64]:
        """Return the thermocouples' readings now, degrees Celsius; empty where none is wired."""
        ...

    def close(self) -> None:
        """Let go of the hardware."""
        ...


def nobody(point: int, hits_so_far: int) -> None:
    """Let whoever holds the hammer read the screen."""


@dataclass(frozen=True)
class HammerRig:
    """Parts of the rig of a hammer test, real or simulated.

    Attributes
    ----------
    open_inputs : callable
        May be called again after the cards were lost.
    clock : Clock
    date : callable
        Date and time of day now, with its zone.
    ask : callable
        Called with the point, counted from 0, that is to be hit, and with the number of hits that were recorded in
        the campaign, rejected ones too. It makes the simulated hammer hit.
    oven : Rig, optional
        With the oven in which the plate is, whose cards are these inputs; None for a plate in the room.
    """

    open_inputs: Callable[[], HammerInputs]
    clock: Clock
    date: Callable[[], datetime]
    ask: Callable[[int, int], None] = nobody
    oven: Rig | None = None


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


SPARE_TIME = 0.002
"""s recorded before and after a block: whoever takes the offset out of it may find the trigger a sample earlier or
later, and still find the block whole."""
MEDIAN_TIME = 1.0
"""s of which the median is taken."""


@dataclass(frozen=True)
class TriggerSettings:
    """When a hit begins, and how much is kept of it.

    Attributes
    ----------
    level : float
        Above rest, V.
    pretrigger : float
        Kept from before, s.
    duration : float
        Of a block, the pretrigger included, s.
    """

    level: float
    pretrigger: float
    duration: float

    def __post_init__(self) -> None:
        check_range(self, 0.0, np.inf, "level", unit="V", above=True)
        check_range(self, 0.0, 10.0, "pretrigger", unit="s")
        if not self.pretrigger < self.duration <= 1000.0:
            raise ValueError(
                f"duration {self.duration:g} s; more than the pretrigger of {self.pretrigger:g} s, at most 1000 s"
            )


class HitTrigger:
    """Looks for hits in what is recorded, block by block.

    Parameters
    ----------
    settings : TriggerSettings
    sample_rate : float
        Hz.
    """

    def __init__(self, settings: TriggerSettings, sample_rate: float) -> None:
        self._level = settings.level
        self._before = round((settings.pretrigger + SPARE_TIME) * sample_rate)
        self._after = round((settings.duration - settings.pretrigger + SPARE_TIME) * sample_rate)
        self._resting = round(MEDIAN_TIME * sample_rate)
        self._held: NDArray[np.float64] | None = None
        self._searched = 0

    def arm(self) -> None:
        """Forget what was recorded so far: a hit counts from now on."""
        if self._held is not None:
            self._searched = self._held.shape[1]

    def reset(self) -> None:
        """Begin anew, with a recording that does not follow on what was fed so far."""
        self._held, self._searched = None, 0

    @property
    def under_way(self) -> bool:
        """Whether a hit has begun whose block is not yet whole."""
        return self._begin() is not None

    def feed(self, block: NDArray[np.float64]) -> NDArray[np.float64] | None:
        """Take what was recorded next; return the record of a hit once it is whole.

        Parameters
        ----------
        block : (C, M) ndarray, V
            Force first.

        Returns
        -------
        (C, N) ndarray or None
            The block of the hit, with `SPARE_TIME` at both ends.
        """
        self._held = block if self._held is None else np.concatenate([self._held, block], axis=1)
        begin = self._begin()
        if begin is None:
            self._searched = self._held.shape[1]
            self._forget(self._searched)
            return None
        if begin + self._after > self._held.shape[1]:
            return None
        record = self._held[:, begin - self._before : begin + self._after].copy()
        self._searched = begin + self._after
        self._forget(self._searched)
        return record

    def _begin(self) -> int | None:
        """Return the first sample, not yet searched, that is above the level; None where none is."""
        if self._held is None:
            return None
        first = max(self._searched, self._before, 1)  # a hit with too little before it tells nothing
        force = self._held[0] - np.median(self._held[0][: max(self._searched, 1)][-self._resting :])
        above = np.abs(force) >= self._level
        rises = np.flatnonzero(above[first:] & ~above[first - 1 : -1])
        return first + int(rises[0]) if len(rises) else None

    def _forget(self, searched: int) -> None:
        """Drop what neither a block nor the level at rest can need."""
        drop = searched - max(self._before, self._resting) - 1
        if self._held is not None and drop > 0:
            self._held = self._held[:, drop:]
            self._searched -= drop
