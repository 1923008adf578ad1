"""How FRFs are identified: where the search begins and ends, residual terms, mains."""

from dataclasses import dataclass

from analysis.identification.residual_terms import CHOICES, ResidualTerms


@dataclass(frozen=True)
class Settings:
    """How FRFs are identified.

    Attributes
    ----------
    start_count : int
        Pole pairs vector fitting starts with; two and a half times as many while more than `FULL` of them stay.
    most_count : int
        Start poles at most.
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
        if self.mains is not None and not 1.0 <= self.mains <= 1000.0:
            raise ValueError(f"mains {self.mains:g} Hz: 1 to 1000 allowed, or none")
