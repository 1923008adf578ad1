"""How much of what a campaign's protocol asks for has been measured."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

State = Literal["running", "interrupted", "ended", "incomplete"]


@dataclass(frozen=True)
class CampaignExtent:
    """Sweeps of a campaign that lacks some of its protocol's.

    Attributes
    ----------
    state : str
        ``running`` (a process is recording it), ``interrupted`` (it can be continued), ``ended`` (what is missing
        was given up, or was left out when the campaign was imported), or ``incomplete`` (a recorder's folder, of
        which no more is known).
    sweeps : int
        Finished ones, 1 or more.
    asked : int
        Those of the protocol.
    given_up : int
        Those of the missing ones that will not come.
    lowest, highest : float
        Temperatures of the finished sweeps, degrees Celsius.
    """

    state: State
    sweeps: int
    asked: int
    given_up: int
    lowest: float
    highest: float

    def __post_init__(self) -> None:
        if self.state not in get_args(State):
            raise ValueError(f"state {self.state!r}: one of {', '.join(get_args(State))} wanted")
        if not 1 <= self.sweeps < self.asked or not 0 <= self.given_up <= self.asked - self.sweeps:
            raise ValueError(
                f"{self.sweeps} of {self.asked} sweeps, {self.given_up} given up: 1 or more of more, and no more "
                "given up than are missing"
            )
        if not self.lowest <= self.highest:
            raise ValueError(f"sweeps from {self.lowest:g} to {self.highest:g} °C: two ascending values wanted")

    @classmethod
    def of(cls, state: State, temperature: Sequence[float], missing: int, given_up: int = 0) -> "CampaignExtent":
        """Return the extent of a campaign of which sweeps are there.

        Parameters
        ----------
        state : str
        temperature : sequence of float
            Of every finished sweep, °C.
        missing : int
            How many more the protocol asks for.
        given_up : int
            How many of these will not come.
        """
        count = len(temperature)
        return cls(state, count, count + missing, given_up, min(temperature), max(temperature))

    @property
    def said(self) -> str:
        """State, sweeps and temperatures: ``interrupted, 20 of 31 sweeps, 15 to 45 °C``."""
        gone = f" ({self.given_up} given up)" if self.given_up and self.state != "ended" else ""
        low, high = f"{self.lowest:z.0f}", f"{self.highest:z.0f}"
        span = low if low == high else f"{low} to {high}"
        state = "ended with sweeps missing" if self.state == "ended" else self.state
        return f"{state}, {self.sweeps} of {self.asked} sweeps{gone}, {span} °C"

    @property
    def note(self) -> str:
        """Say what the results of such a campaign are worth."""
        onward = (
            "the missing ones were given up, or left out when the campaign was imported"
            if self.state == "ended"
            else "results hold for these; do the same again when more sweeps are there"
        )
        return f"the campaign is not complete: {self.said}; {onward}"
