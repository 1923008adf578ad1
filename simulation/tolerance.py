"""A declared quantity of the twin that is not exact."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from simulation.effects.effect import Effect

RANGE_IN_TOLERANCES = 8.0
"""Range of every quantity, in tolerances: far enough to see that a declaration is wrong."""

Change = Callable[[Any, Mapping[str, Any]], dict[str, Any]]
"""(departures, or anything with their attributes; values) -> attributes of `Departures` that change."""


@dataclass(frozen=True)
class Tolerance(Effect):
    """A declared quantity, and what it changes in the departures.

    Attributes
    ----------
    change : Change or None
        None where it changes the state otherwise.
    made_at : mapping
        Values about which the twin was made; empty where these are the declared ones. Changes count from there.
    """

    change: Change | None = None
    made_at: Mapping[str, float] = field(default_factory=dict)

    def changed(self, away: Any, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return the attributes of departures that these values change."""
        if self.change is None:
            raise ValueError("this quantity is no departure")
        if self.made_at:
            values = {name: value - self.made_at.get(name, 0.0) for name, value in values.items()}
        return self.change(away, values)
