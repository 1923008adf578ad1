"""Filters between the training temperatures by interpolation: what a network has to beat."""

import numpy as np

from analysis.arrays import Complex, Real
from analysis.focusing.fir import FirBank

FINER = 32
"""Lines of a response in the width of one peak its taps can resolve: a spline through them is exact to 1e-5."""


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
        Abscissae of the training filters: temperatures, °C, or log √D(T), along which the modes move evenly and
        the spline has less to bend.
    places : (T,) ndarray
        Abscissae wanted, of the same kind.

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

    A plate of another stiffness answers at f as this one does at f √(D'/D), D'/D times as much, as far as
    ν, η and the patches leave it alike. Interpolating what is left over four neighbours, the resonances
    stand still.

    Parameters
    ----------
    filters : FirBank
        At the training temperatures; taps answer at any frequency.
    knots, places : (n,) and (T,) ndarray
        log √D at the training and at the wanted temperatures.
    frequency : (F,) ndarray, Hz

    Returns
    -------
    (T, F, N) complex ndarray
        Responses of the filters wanted.
    """
    from scipy.interpolate import CubicSpline

    ascending = np.argsort(knots)
    knots = knots[ascending]
    reach = np.exp(knots[-1] - knots[0])
    spacing = filters.sample_rate / (FINER * filters.taps.shape[2])
    lines = np.arange(frequency[0] / reach, frequency[-1] * reach + 2.0 * spacing, spacing)
    along = [CubicSpline(lines, response) for response in filters.response(lines)[ascending]]
    width = min(4, len(knots))
    result = np.empty((len(places), len(frequency), filters.taps.shape[1]), dtype=complex)
    for t, place in enumerate(np.clip(places, knots[0], knots[-1])):
        first = int(np.clip(np.searchsorted(knots, place) - width // 2, 0, len(knots) - width))
        stencil = np.arange(first, first + width)
        total = np.zeros(result.shape[1:], dtype=complex)
        for i in stencil:
            others = knots[stencil[stencil != i]]
            weight = np.prod((place - others) / (knots[i] - others))
            total += weight * np.exp(2.0 * (place - knots[i])) * along[i](frequency * np.exp(knots[i] - place))
        result[t] = total
    return result
