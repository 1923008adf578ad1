"""Filters between the training temperatures by interpolation: what a network has to beat."""

import numpy as np
from scipy.interpolate import CubicSpline

from analysis.arrays import Complex, Real
from analysis.focusing.fir import FirBank


def linear(filters: FirBank, temperature: Real) -> Real:
    """Taps (T, N, M) on straight lines between neighbouring training temperatures."""
    knots = filters.temperature
    place = np.clip(np.searchsorted(knots, temperature, side="right") - 1, 0, len(knots) - 2)
    share = np.clip((temperature - knots[place]) / (knots[place + 1] - knots[place]), 0.0, 1.0)[:, None, None]
    taps: Real = (1.0 - share) * filters.taps[place] + share * filters.taps[place + 1]
    return taps


def cubic_spline(filters: FirBank, knots: Real, places: Real) -> Real:
    """Taps (T, N, M) on a cubic not-a-knot spline of each tap.

    `knots` (n,) are the abscissae of the training filters and `places` (T,) those wanted: temperatures, or
    log √D(T), along which the modes move evenly and the spline has less to bend.
    """
    ascending = np.argsort(knots)
    low, high = knots[ascending[0]], knots[ascending[-1]]
    spline = CubicSpline(knots[ascending], filters.taps[ascending], axis=0)
    taps: Real = spline(np.clip(places, low, high))
    return taps


def log_root_rigidity(youngs_modulus: Real, poisson_ratio: Real) -> Real:
    """Return log √D up to a constant, with the bending stiffness D = E h³/12/(1 - ν²)."""
    u: Real = 0.5 * np.log(youngs_modulus / (1.0 - poisson_ratio**2))
    return u


def reduced_frequency(filters: Complex, lines: Real, knots: Real, places: Real, frequency: Real) -> Complex:
    """Complex filters (T, F, N) interpolated at equal reduced frequency f/√D.

    A plate of another stiffness answers at f as this one does at f √(D'/D), D'/D times as much, as far as
    ν, η and the patches leave it alike. Interpolating what is left over four neighbours, the resonances
    stand still.

    Parameters
    ----------
    filters : (n, L, N) ndarray
        STIF filters at the training temperatures, untapered.
    lines : (L,) ndarray
        Their frequencies, Hz: `frequency` and, as far as possible, its neighbourhood. Beyond the lines a
        filter is held at its last value.
    knots, places : (n,) and (T,) ndarray
        log √D at the training and at the wanted temperatures.
    frequency : (F,) ndarray, Hz
    """
    ascending = np.argsort(knots)
    knots, filters = knots[ascending], filters[ascending]
    along = [CubicSpline(lines, stiff * np.exp(-2.0 * knot)) for stiff, knot in zip(filters, knots, strict=True)]
    width = min(4, len(knots))
    result = np.empty((len(places), len(frequency), filters.shape[2]), dtype=complex)
    for t, place in enumerate(np.clip(places, knots[0], knots[-1])):
        first = int(np.clip(np.searchsorted(knots, place) - width // 2, 0, len(knots) - width))
        stencil = np.arange(first, first + width)
        total = np.zeros(result.shape[1:], dtype=complex)
        for i in stencil:
            others = knots[stencil[stencil != i]]
            weight = np.prod((place - others) / (knots[i] - others))
            shifted = np.clip(frequency * np.exp(knots[i] - place), lines[0], lines[-1])
            total += weight * along[i](shifted)
        result[t] = total * np.exp(2.0 * place)
    return result
