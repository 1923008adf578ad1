"""Observability: effects of which this campaign holds no information, and what would show them."""

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
    """How well one effect can be observed in a campaign.

    Attributes
    ----------
    effect : str
    kept : float
        Share of the effect's tangent, 0 to 1, that is independent of laws, gain and the effects already found; of
        its best direction where there are several parameters, at its best site.
    size : float
        Of an effect of one prior standard deviation, in sigma, errors of the readings included.
    needs : str
        What a campaign must hold to show it.
    """

    effect: str
    kept: float
    size: float
    needs: str

    @property
    def observable(self) -> bool:
        """Whether its presence could be claimed or excluded."""
        return self.kept >= LEAST_KEPT and self.size >= LEAST_SIZE


def observability(screening: ScoreTest, cards: Mapping[str, EffectCard]) -> tuple[Observability, ...]:
    """Look at every effect that is off."""
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
    """Root of the largest x'matrix x over x'against x."""
    trace = float(np.trace(against))
    if trace <= 0.0:
        return 0.0
    regular = against + 1e-12 * trace * np.eye(len(against))
    return float(np.sqrt(max(float(eigh(matrix, regular, eigvals_only=True)[-1]), 0.0)))
