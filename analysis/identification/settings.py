"""Settings of the identification: limits of the search, residual terms, mains frequency."""

from dataclasses import dataclass

from analysis.grid_frequency import require_mains
from analysis.identification.residual_terms import CHOICES, ResidualTerms


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
