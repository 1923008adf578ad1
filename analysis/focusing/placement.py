"""Placement of actuators: exchange of candidate positions and small moves that maximise a score."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Numbers, Real

Index = NDArray[np.int64]
Score = Callable[[Numbers], Real]


@dataclass(frozen=True)
class Placement:
    """A set of candidates that no single exchange improves.

    Attributes
    ----------
    chosen : (N,) ndarray
        Candidate numbers, ascending.
    score : float
        Of the chosen set.
    scores : (S,) ndarray
        Final score of each start: their spread shows how many local optima there are.
    """

    chosen: Index
    score: float
    scores: Real


def clearance(centers: Real, gap: float) -> NDArray[np.bool_]:
    """Which pairs of candidates (C, C) are compatible: centres (C, 2) at least `gap` apart in x or in y, m."""
    apart = np.abs(centers[:, None] - centers[None]).max(axis=-1)
    free: NDArray[np.bool_] = apart >= gap - 1e-9
    return free


def exchange(
    score: Score,
    compatible: NDArray[np.bool_],
    count: int,
    rng: np.random.Generator,
    starts: int = 8,
    sweeps: int = 20,
) -> Placement:
    """Best of several exchange searches, each from a random set.

    One sweep replaces each actuator in turn by the candidate of best score with the others held; the search ends
    when a sweep changes nothing (Fedorov's exchange, with a score instead of a determinant).

    Parameters
    ----------
    score : callable
        From sets of candidates (S, count), int, to their values (S,); the larger the better.
    compatible : (C, C) ndarray of bool
        Which pairs of candidates may be combined.
    count : int
        Candidates in a set.
    rng : numpy Generator
        Draws the first sets.
    starts : int
        Searches.
    sweeps : int
        Largest number of sweeps of one search.

    Returns
    -------
    Placement
        The best set, its value, and the value where each search ended.

    Raises
    ------
    ValueError
        Where no set of `count` compatible candidates is found.
    """
    ends: list[tuple[float, Index]] = []
    for _ in range(starts):
        chosen = _random_set(compatible, count, rng)
        best = float(score(chosen[None])[0])
        for _ in range(sweeps):
            before = best
            for place in range(count):
                rest = np.delete(chosen, place)
                free = np.flatnonzero(compatible[:, rest].all(axis=1)).astype(np.int64)
                sets = np.concatenate([np.broadcast_to(rest, (len(free), count - 1)), free[:, None]], axis=1)
                values = score(sets)
                if values.max() > best:
                    best, chosen = float(values.max()), sets[int(np.argmax(values))]
            if best <= before:
                break
        ends.append((best, np.sort(chosen)))
    best, chosen = max(ends, key=lambda end: end[0])
    return Placement(chosen, best, np.array([value for value, _ in ends]))


def refined(
    score: Score, centers: Real, allowed: Callable[[Real], bool], steps: Sequence[float]
) -> tuple[Real, float]:
    """Move one actuator at a time to the best of its eight neighbours, in ever smaller steps.

    The step is reduced when no move improves the score.

    Parameters
    ----------
    score : callable
        From layouts (S, N, 2) to their values (S,); the larger the better.
    centers : (N, 2) ndarray, m
        Start positions.
    allowed : callable
        Whether a layout (N, 2) can be built.
    steps : sequence of float
        m.

    Returns
    -------
    centers : (N, 2) ndarray, m
    value : float
        Its score.
    """
    best = float(score(centers[None])[0])
    around = np.array([(x, y) for x in (-1, 0, 1) for y in (-1, 0, 1) if x or y], dtype=float)
    for step in steps:
        before = -np.inf
        while best > before:
            before = best
            for place in range(len(centers)):
                moves = np.repeat(centers[None], len(around), axis=0)
                moves[:, place] += step * around
                moves = moves[[allowed(layout) for layout in moves]]
                values = score(moves) if len(moves) else np.array([-np.inf])
                if values.max() > best:
                    best, centers = float(values.max()), moves[int(np.argmax(values))]
    return centers, best


def _random_set(compatible: NDArray[np.bool_], count: int, rng: np.random.Generator) -> Index:
    for _ in range(100):
        chosen: list[int] = []
        for candidate in rng.permutation(len(compatible)):
            if compatible[candidate, chosen].all():
                chosen.append(int(candidate))
            if len(chosen) == count:
                return np.array(chosen, dtype=np.int64)
    raise ValueError(f"no {count} of the {len(compatible)} candidates are compatible")
