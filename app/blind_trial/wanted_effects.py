"""Hidden effect of a campaign of a trial, and a protocol that can show it."""

from collections.abc import Sequence

import numpy as np

from app.blind_trial.assignments import KINDS, Assignment, shuffled
from app.blind_trial.unlisted_effects import UNLISTED_EFFECTS

BOTH_WAYS = ("thermal_lag", "annealing", "depolarization")
"""Effects that only an up and a down ramp show."""
TWO_LEVELS = ("amplitude_softening", "piezo_nonlinearity")
"""Effects that only two levels show."""


def wanted(assignment: Assignment, names: Sequence[str], stream: str, seed: int) -> tuple[str, ...]:
    """Name of the effect to hide; the second of a pair is chosen later, when the plate is known.

    Parameters
    ----------
    assignment : Assignment
    names : sequence of str
        Effects to choose from; the kind ``outside`` has its own.
    stream, seed : str, int
        See `shuffled`.

    Returns
    -------
    tuple of str
        One name; empty for the kind ``null``.
    """
    word = KINDS.index(assignment.kind)
    match assignment.kind:
        case "null":
            return ()
        case "outside":
            return (shuffled(tuple(UNLISTED_EFFECTS), stream, seed, assignment.ordinal, word),)
        case _:
            return (shuffled(names, stream, seed, assignment.ordinal, word),)


def ways(names: Sequence[str], rng: np.random.Generator) -> tuple[tuple[str, ...], tuple[float, ...]]:
    """Legs and levels that can show all `names`; two legs are also used in a third of the other campaigns."""
    legs = ("up", "down") if set(BOTH_WAYS) & set(names) or rng.random() < 1.0 / 3.0 else ("up",)
    levels = (1.0, 2.0) if set(TWO_LEVELS) & set(names) else (1.0,)
    return legs, levels


def partners(names: Sequence[str], legs: Sequence[str], levels: Sequence[float]) -> tuple[str, ...]:
    """Return the effects that a campaign can show.

    Parameters
    ----------
    names : sequence of str
        Of effects.
    legs : sequence of str
    levels : sequence of float

    Returns
    -------
    tuple of str
        Of `names`.
    """
    blind = set(BOTH_WAYS) if len(legs) < 2 else set()
    blind |= set(TWO_LEVELS) if len(levels) < 2 else set()
    return tuple(name for name in names if name not in blind)
