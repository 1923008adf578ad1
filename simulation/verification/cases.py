"""All verification cases."""

from simulation.verification.case import Case
from simulation.verification.exact_cases import EXACT
from simulation.verification.published import PUBLISHED

CASES: tuple[Case, ...] = (*EXACT, *PUBLISHED)
