"""Settings of the identification: limits of the search, band, residual terms, mains frequency."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.identification.pole_residue import CHOICES, ResidualTerms
from analysis.recordings.grid_frequency import require_mains


@dataclass(frozen=True)
class Settings:
    """Settings of the identification.

    Attributes
    ----------
    start_count : int
        Pole pairs vector fitting starts with; 2.5 times as many in the next search if more than 60 % are kept.
    most_count : int
        Largest number of start poles.
    terms : tuple of ResidualTerms
        BIC chooses among these.
    mains : float or None
        Mains frequency, Hz; narrow poles at its harmonics are flagged.
    """

    start_count: int = 24
    most_count: int = 150
    terms: tuple[ResidualTerms, ...] = CHOICES
    mains: float | None = 50.0

    def __post_init__(self) -> None:
        if not 1 <= self.start_count <= self.most_count <= 500:
            raise ValueError(
                f"start_count {self.start_count} and most_count {self.most_count}: 1 to 500, in this order, wanted"
            )
        if not self.terms:
            raise ValueError("terms: at least one choice of residual terms is needed")
        if self.mains is not None:
            require_mains(self.mains)


LEAST_LINES = 8
"""Of fewer, no pole can be told."""


def lines_inside(frequency: NDArray[np.float64], band: tuple[float, float]) -> NDArray[np.bool_]:
    """Return which lines lie in a band, both ends included.

    Parameters
    ----------
    frequency : (F,) ndarray
        Hz, ascending.
    band : (float, float)
        Hz.

    Returns
    -------
    (F,) bool ndarray

    Raises
    ------
    ValueError
        Where it holds too few.
    """
    inside: NDArray[np.bool_] = (frequency >= band[0]) & (frequency <= band[1])
    if inside.sum() < LEAST_LINES:
        spacing = float(np.median(np.diff(frequency)))
        raise ValueError(
            f"--band {band[0]:g} {band[1]:g}: {int(inside.sum())} frequency lines; at least {LEAST_LINES} are "
            f"needed. Allowed: within {frequency[0]:g} to {frequency[-1]:g} Hz, at least "
            f"{LEAST_LINES * spacing:.3g} Hz wide"
        )
    return inside
