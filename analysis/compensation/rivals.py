"""Methods that networks are compared with: interpolation and principal filters."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.polynomial.chebyshev import chebinterpolate, chebvander
from numpy.typing import NDArray

from analysis.arrays import Complex, Real
from analysis.compensation.network import LowRankBank
from analysis.compensation.outcome import LINEAR, LOW_RANK, REDUCED_FREQUENCY, RIGIDITY_SPLINE, SPLINE
from analysis.focusing.design import FieldFit, fitted
from analysis.focusing.fir import FirBank
from analysis.focusing.panel import Panel
from analysis.material import MaterialLaws

Predictor = Callable[[FirBank, Real], Real]


def linear(filters: FirBank, temperature: Real) -> Real:
    """Taps (T, N, M) on straight lines between neighbouring training temperatures."""
    knots = filters.temperature
    place = np.clip(np.searchsorted(knots, temperature, side="right") - 1, 0, len(knots) - 2)
    share = np.clip((temperature - knots[place]) / (knots[place + 1] - knots[place]), 0.0, 1.0)[:, None, None]
    taps: Real = (1.0 - share) * filters.taps[place] + share * filters.taps[place + 1]
    return taps


def cubic_spline(filters: FirBank, knots: Real, places: Real) -> Real:
    """Taps on a cubic not-a-knot spline of each tap; beyond the knots, those of the nearest end.

    Parameters
    ----------
    filters : FirBank
        At the n training temperatures.
    knots : (n,) ndarray
        Abscissae of the training filters: temperatures, °C, or log √D(T), with which log frequencies change
        linearly, so that the spline is smoother.
    places : (T,) ndarray
        Abscissae at which taps are computed, of the same kind.

    Returns
    -------
    (T, N, M) ndarray
        Taps, V per unit of audio signal.
    """
    from scipy.interpolate import CubicSpline

    ascending = np.argsort(knots)
    low, high = knots[ascending[0]], knots[ascending[-1]]
    spline = CubicSpline(knots[ascending], filters.taps[ascending], axis=0)
    taps: Real = spline(np.clip(places, low, high))
    return taps


def log_root_rigidity(youngs_modulus: Real, poisson_ratio: Real) -> Real:
    """Return log √D up to a constant, with the bending stiffness D = E h³/12/(1 - ν²)."""
    u: Real = 0.5 * np.log(youngs_modulus / (1.0 - poisson_ratio**2))
    return u


def reduced_frequency(filters: FirBank, knots: Real, places: Real, frequency: Real) -> Complex:
    """Complex responses (T, F, N) interpolated at equal reduced frequency f/√D, modelling delay taken out.

    A plate of stiffness D responds at f as one of stiffness D' does at f √(D'/D), D'/D times as much, if ν, η and
    the patches' share are equal. At equal reduced frequency resonances coincide; the remaining change is
    interpolated over four neighbours.

    Parameters
    ----------
    filters : FirBank
        At the training temperatures; their responses can be computed at any frequency.
    knots, places : (n,) and (T,) ndarray
        log √D at the training and at the wanted temperatures.
    frequency : (F,) ndarray, Hz

    Returns
    -------
    (T, F, N) complex ndarray
        Responses of the filters wanted.
    """
    ascending = np.argsort(knots)
    knots = knots[ascending]
    width, places = min(4, len(knots)), np.clip(places, knots[0], knots[-1])
    firsts = np.clip(np.searchsorted(knots, places) - width // 2, 0, len(knots) - width)
    reach = np.exp(knots[-1] - knots[0])
    series = _Series.of(filters, frequency[0] / reach, frequency[-1] * reach)
    result = np.empty((len(places), len(frequency), filters.taps.shape[1]), dtype=complex)
    for t, (place, first) in enumerate(zip(places, firsts, strict=True)):
        stencil = slice(first, first + width)
        stretch = np.exp(knots[stencil] - place)
        near = series.at(ascending[stencil], frequency * stretch[:, None])
        result[t] = np.tensordot(_lagrange(knots[stencil], place) / stretch**2, near, axes=1)
    return result


def _lagrange(points: Real, place: float) -> Real:
    """Weights (n,) at a `place` of values at `points` (n,), for the polynomial through them."""
    own = np.eye(len(points), dtype=bool)
    shares = np.where(own, 1.0, place - points) / np.where(own, 1.0, points[:, None] - points)
    return np.asarray(shares.prod(axis=1))


@dataclass(frozen=True)
class _Series:
    """Chebyshev series of the responses of a bank at n temperatures over a range of frequencies.

    Attributes
    ----------
    middle, half : float
        Of the range, Hz.
    coefficients : (n, d, 2 N) ndarray
        Of the real parts, then of the imaginary ones.
    """

    middle: float
    half: float
    coefficients: Real

    @classmethod
    def of(cls, filters: FirBank, low: float, high: float) -> Self:
        middle, half = 0.5 * (low + high), 0.5 * (high - low) or 1.0  # one line alone: any range will do
        # The last tap's phase turns by so many radians over half the range, and its series needs little more
        # terms: Bessel functions fall below rounding ten cube roots beyond their argument.
        reach = max(filters.delay, filters.taps.shape[2] - filters.delay)
        turned = 2.0 * np.pi * half * reach / filters.sample_rate
        count = int(np.ceil(turned + 10.0 * np.cbrt(turned + 1.0)))

        def responses(points: Real) -> Any:  # NumPy's types know of numbers only, its code of arrays as well
            found = filters.response(middle + half * points).swapaxes(0, 1)
            return np.concatenate([found.real, found.imag], axis=2).reshape(len(points), -1)

        coefficients = chebinterpolate(responses, count - 1).reshape(count, len(filters.taps), -1)
        return cls(middle, half, coefficients.swapaxes(0, 1))

    def at(self, which: NDArray[np.intp], frequency: Real) -> Complex:
        """Responses (k, F, N) at the temperatures `which` (k,), each at frequencies of its own (k, F), Hz."""
        terms = chebvander((frequency - self.middle) / self.half, self.coefficients.shape[1] - 1)
        real, imaginary = np.split(terms @ self.coefficients[which], 2, axis=2)
        return np.asarray(real + 1j * imaginary)


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
