"""What a hammer test needs: inputs that are read without end, whoever holds the hammer, and storage."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from drivers.clock import Clock
from drivers.hammer.judged_hit import HitTemperature, JudgedHit
from drivers.hammer.progress import HammerProgress, KeptHit
from drivers.ni.cards import go_on
from drivers.rig.rig import Rig


class HammerInputs(Protocol):
    """Force and responses, read block by block; see `drivers.ni.endless_inputs.EndlessInputs`."""

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
