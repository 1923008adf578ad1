"""Hidden effect of a campaign of a trial, and a protocol that can show it."""

from collections.abc import Sequence

import numpy as np

from app.blind_trial.assignments import KINDS, Assignment, shuffled
from app.blind_trial.unlisted_effects import UNLISTED_EFFECTS

STRANGE = ("resonator", *UNLISTED_EFFECTS)


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
            return (shuffled(STRANGE, stream, seed, assignment.ordinal, word),)
        case _:
            return (shuffled(names, stream, seed, assignment.ordinal, word),)


def ways(names: Sequence[str], rng: np.random.Generator) -> tuple[tuple[str, ...], tuple[float, ...]]:
    """Legs and levels that can show all `names`; two legs are also used in a third of the other campaigns."""
    legs = ("up", "down") if "thermal_lag" in names or rng.random() < 1.0 / 3.0 else ("up",)
    levels = (1.0, 2.0) if "amplitude_softening" in names else (1.0,)
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
    blind = {"thermal_lag"} if len(legs) < 2 else set()
    blind |= {"amplitude_softening"} if len(levels) < 2 else set()
    return tuple(name for name in names if name not in blind)
