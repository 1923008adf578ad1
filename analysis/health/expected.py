"""What a panel answers at one temperature, and how every unknown changes it."""

from dataclasses import dataclass
from typing import Protocol

from analysis.arrays import Complex, Real
from analysis.checked_fields import check_finite, check_shapes


@dataclass(frozen=True)
class ExpectedResponse:
    """Responses of a panel to each of I inputs at K outputs, at n nodes of frequency, with derivatives.

    Attributes
    ----------
    temperature : float
        Degrees Celsius.
    response : (I, K, n) complex ndarray
        In the units of the recordings.
    nuisances : (N, I, K, n) complex ndarray
        By what may differ from date to date without anything being wrong; the first is the temperature, per K.
    nuisance_sigma : (N,) ndarray
        Their standard deviations.
    changes : (C, I, K, n) complex ndarray
        By the amplitude of every candidate; C may be 0.
    """

    temperature: float
    response: Complex
    nuisances: Complex
    nuisance_sigma: Real
    changes: Complex

    def __post_init__(self) -> None:
        check_shapes(self, response="I K n", nuisances="N I K n", nuisance_sigma="N", changes="C I K n")
        check_finite(self, "temperature", "response")


class ExpectsResponses(Protocol):
    """A panel whose healthy responses are known at any temperature of a range."""

    @property
    def temperature_range(self) -> tuple[float, float]:
        """Lowest and highest temperature at which it is known, degrees Celsius."""
        ...

    def at(self, temperature: float, *, changes: bool = True) -> ExpectedResponse:
        """Return responses at a temperature [degrees Celsius]; without columns of candidates if not `changes`."""
        ...
