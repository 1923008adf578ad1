"""Kind of each campaign of a trial: random by seed, with kinds spread evenly so that any part is a fair sample."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

Kind = Literal["null", "single", "pair", "outside", "ablated"]
KINDS: tuple[Kind, ...] = get_args(Kind)
SHARES: dict[Kind, int] = {"null": 5, "single": 7, "pair": 3, "outside": 2, "ablated": 3}
"""Campaigns of each kind in twenty."""
STREAMS = {"trial": 0, "calibration": 1}
"""First word of every seed, so that the streams have no campaign in common."""


@dataclass(frozen=True)
class Assignment:
    """One campaign of a trial.

    Attributes
    ----------
    number : int
        From 0.
    kind : str
    ordinal : int
        Number among those of its kind, from 0.
    """

    number: int
    kind: Kind
    ordinal: int

    @property
    def name(self) -> str:
        """Name of its files and folders."""
        return f"{self.number:04d}"

    def rng(self, stream: str, seed: int) -> np.random.Generator:
        """Return the random generator of this campaign."""
        return np.random.default_rng([STREAMS[stream], seed, 1, self.number])


def assignments(count: int, kinds: Sequence[Kind]) -> tuple[Assignment, ...]:
    """Return `count` assignments; every kind has its share in each section of them."""
    dealt = dict.fromkeys(kinds, 0)
    found = []
    for number in range(count):
        kind = min(kinds, key=lambda k: ((dealt[k] + 0.5) / SHARES[k], KINDS.index(k)))
        found.append(Assignment(number, kind, dealt[kind]))
        dealt[kind] += 1
    return tuple(found)


def shuffled(names: Sequence[str], stream: str, seed: int, ordinal: int, word: int) -> str:
    """Return the `ordinal`-th of a random sequence of `names`: each once per round, every round in another order.

    Parameters
    ----------
    names : sequence of str
    stream : str
        One of `STREAMS`.
    seed : int
    ordinal : int
        From 0.
    word : int
        Part of the seed: different words give orders independent of each other.

    Returns
    -------
    str
    """
    turn, place = divmod(ordinal, len(names))
    order = np.random.default_rng([STREAMS[stream], seed, 2, word, turn]).permutation(len(names))
    return names[int(order[place])]
