"""Effects that this campaign cannot show, with the measurement that would; effects that it cannot tell apart."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from analysis.arrays import Real
from analysis.effect_card import EffectCard
from analysis.gap.search.score_test import ScoreTest
from analysis.gap.thresholds import LEAST_KEPT, LEAST_SIZE


@dataclass(frozen=True)
class Observability:
    """Observability of one effect in a campaign.

    Attributes
    ----------
    effect : str
    kept : float
        Share of the effect's tangent, 0 to 1, that is independent of laws, gain and the effects already found;
        with several parameters, of the best direction; at its best site.
    size : float
        Signal of an effect of one prior standard deviation, in sigma, with errors of the readings eliminated.
    needs : str
        What a campaign must contain to show it.
    levels : bool
        Whether the drive had as many levels as that: what one level shows of an effect that follows the amplitude
        is some curve over frequency, which other causes have as well.
    """

    effect: str
    kept: float
    size: float
    needs: str
    levels: bool = True

    @property
    def felt(self) -> bool:
        """Whether a part of its signal is its own, and large enough."""
        return self.kept >= LEAST_KEPT and self.size >= LEAST_SIZE

    @property
    def observable(self) -> bool:
        """Whether its presence can be claimed or excluded."""
        return self.levels and self.felt


def observability(screening: ScoreTest, cards: Mapping[str, EffectCard], levels: int) -> tuple[Observability, ...]:
    """Observability of every effect that is off, in a campaign of so many `levels` of the drive."""
    matrix, read = screening.given(screening.active)[0], screening.kept(screening.active)
    seen = []
    for name in screening.inactive:
        kept, size = 0.0, 0.0
        for site in screening.sites(name):
            places = screening.of(name, site)
            block = np.ix_(places, places)
            sigma = np.array([screening.columns[i].card.sigma for i in places])
            scale = sigma[:, None] * sigma
            size = max(size, _largest(scale * matrix[block], np.eye(len(places))))
            kept = max(kept, _largest(scale * read[block], scale * screening.raw[block]))
        card = cards[name]
        seen.append(Observability(name, min(kept, 1.0), size, card.needs, levels >= card.levels))
    return tuple(seen)


def _largest(matrix: NDArray[np.float64], against: NDArray[np.float64]) -> float:
    """Square root of the largest x'matrix x / x'against x."""
    trace = float(np.trace(against))
    if trace <= 0.0:
        return 0.0
    regular = against + 1e-12 * trace * np.eye(len(against))
    return float(np.sqrt(max(float(eigh(matrix, regular, eigvals_only=True)[-1]), 0.0)))


def tangent_cosines(screening: ScoreTest, effects: Sequence[tuple[str, int]]) -> Real:
    """Largest canonical correlation of the tangents of every pair of `effects` (name, site): (C, C) ndarray."""
    matrix, _ = screening.given([name for name in screening.active if name not in {e for e, _ in effects}])
    bases = []
    for name, site in effects:
        places = screening.of(name, site)
        values, vectors = np.linalg.eigh(_unit(matrix[np.ix_(places, places)]))
        scale = 1.0 / np.sqrt(np.maximum(np.diag(matrix)[places], 1e-300))
        good = values > 1e-9
        bases.append((places, scale[:, None] * vectors[:, good] / np.sqrt(values[good])))
    table = np.eye(len(effects))
    for i, (a, left) in enumerate(bases):
        for j, (b, right) in enumerate(bases[:i]):
            cross = left.T @ matrix[np.ix_(a, b)] @ right
            value = float(np.linalg.svd(cross, compute_uv=False)[0]) if cross.size else 0.0
            table[i, j] = table[j, i] = min(value, 1.0)
    return table


def signal_cosine(screening: ScoreTest, effect: str, other: str) -> float:
    """Cosine between the signal of an effect that is on and the nearest signal of another effect.

    Unlike a canonical correlation it uses the direction found, not the most similar directions of two subspaces.

    Parameters
    ----------
    screening : ScoreTest
    effect : str
        On at the score test's state.
    other : str
        Taken at its best site.

    Returns
    -------
    float
        0 to 1.
    """
    rest = [name for name in screening.active if name not in (effect, other)]
    matrix, _ = screening.given(rest)
    mine = [i for i in screening.of(effect) if not screening.columns[i].card.shape]
    value = np.array([screening.columns[i].at for i in mine])
    power = float(value @ matrix[np.ix_(mine, mine)] @ value)
    if power <= 0.0:
        return 0.0
    best = 0.0
    for site in screening.sites(other):
        theirs = screening.of(other, site)
        cross = matrix[np.ix_(theirs, mine)] @ value
        block = matrix[np.ix_(theirs, theirs)]
        scale = 1.0 / np.sqrt(np.maximum(np.diag(block), 1e-300))
        unit = _unit(block) + 1e-9 * np.eye(len(theirs))
        explained = float((scale * cross) @ np.linalg.solve(unit, scale * cross))
        best = max(best, explained / power)
    return float(np.sqrt(min(best, 1.0)))


def _unit(matrix: Real) -> Real:
    scale = 1.0 / np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    unit: Real = matrix * scale[:, None] * scale
    return unit
