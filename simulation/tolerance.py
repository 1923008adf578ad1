"""A declared quantity of the twin that is not exact."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from simulation.effects.effect import Effect

FARTHEST = 8.0
"""Range of every quantity, in tolerances: far enough to see that a declaration is wrong."""

Change = Callable[[Any, Mapping[str, Any]], dict[str, Any]]
"""(departures, or anything with their attributes; values) -> attributes of `Departures` that change."""


@dataclass(frozen=True)
class Tolerance(Effect):
    """A declared quantity, and what it changes in the departures; None where it changes the state otherwise."""

    change: Change | None = None
