"""Sweeps and hits whose temperature is in doubt, in sentences."""

from collections.abc import Mapping

MOST_NAMED = 6
"""That are named one by one; of more, their number is given."""


def said_of_doubts(doubts: Mapping[str, str], many: str) -> list[str]:
    """Return a note for each of the first, and one for the others.

    Parameters
    ----------
    doubts : mapping of str to str
        Why, by the name that people know it by.
    many : str
        What they are: ``sweeps``, ``hits``.
    """
    notes = [f"the temperature of {name} is in doubt: {why}" for name, why in doubts.items()]
    if len(notes) > MOST_NAMED:
        notes = [*notes[:MOST_NAMED], f"and the temperature of {len(notes) - MOST_NAMED} more {many} is in doubt"]
    return notes
