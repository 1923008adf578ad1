"""Methods that networks are compared with: interpolation and principal filters."""

from collections.abc import Callable

from analysis.arrays import Real
from analysis.compensation.interpolation import cubic_spline, linear, log_root_rigidity, reduced_frequency
from analysis.compensation.low_rank import LowRankBank
from analysis.compensation.outcome import LINEAR, LOW_RANK, REDUCED_FREQUENCY, RIGIDITY_SPLINE, SPLINE
from analysis.focusing.design import fitted
from analysis.focusing.field_fir import FieldFit
from analysis.focusing.fir import FirBank
from analysis.focusing.panel import Panel
from analysis.material import MaterialLaws

Predictor = Callable[[FirBank, Real], Real]


def plain_rivals() -> dict[str, Predictor]:
    """Methods without laws, by name: taps (T, N, M) from filters and temperatures (T,), °C."""
    return {
        LINEAR: linear,
        SPLINE: lambda bank, temperature: cubic_spline(bank, bank.temperature, temperature),
        LOW_RANK: lambda bank, temperature: LowRankBank.of(bank).taps(temperature),
    }


def rivals(panel: Panel, laws: MaterialLaws) -> dict[str, Predictor]:
    """All methods, by name: taps (T, N, M) from filters and temperatures (T,), °C."""

    def u(temperature: Real) -> Real:
        return rigidity(laws, temperature)

    def rigidity_spline(bank: FirBank, temperature: Real) -> Real:
        return cubic_spline(bank, u(bank.temperature), u(temperature))

    lines, fit = panel.filters.frequency, FieldFit.of(panel.filters)

    def equal_reduced_frequency(bank: FirBank, temperature: Real) -> Real:
        wanted = reduced_frequency(bank, u(bank.temperature), u(temperature), lines)
        return fitted(wanted, temperature, fit, bank.delay).taps

    return plain_rivals() | {RIGIDITY_SPLINE: rigidity_spline, REDUCED_FREQUENCY: equal_reduced_frequency}


def rigidity(laws: MaterialLaws, temperature: Real) -> Real:
    """Return log √D (T,) of a plate at `temperature` (T,), °C."""
    material = laws.at(temperature)
    return log_root_rigidity(material.youngs_modulus, material.poisson_ratio)
