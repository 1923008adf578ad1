"""Observability: effects that this campaign cannot show, and the measurement that would."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

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
    """

    effect: str
    kept: float
    size: float
    needs: str

    @property
    def observable(self) -> bool:
        """Whether its presence can be claimed or excluded."""
        return self.kept >= LEAST_KEPT and self.size >= LEAST_SIZE


def observability(screening: ScoreTest, cards: Mapping[str, EffectCard]) -> tuple[Observability, ...]:
    """Observability of every effect that is off."""
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
        seen.append(Observability(name, min(kept, 1.0), size, cards[name].needs))
    return tuple(seen)


def _largest(matrix: NDArray[np.float64], against: NDArray[np.float64]) -> float:
    """Square root of the largest x'matrix x / x'against x."""
    trace = float(np.trace(against))
    if trace <= 0.0:
        return 0.0
    regular = against + 1e-12 * trace * np.eye(len(against))
    return float(np.sqrt(max(float(eigh(matrix, regular, eigvals_only=True)[-1]), 0.0)))
