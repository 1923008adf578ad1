"""Smooth E(T), nu(T), eta(T) with bands, from estimates at single temperatures.

Penalised cubic splines (Eilers and Marx, Statistical Science 11, 1996): many knots, a penalty on the second
differences of the coefficients, and the penalty's strength chosen by restricted maximum likelihood, so that
the data decide how smooth a law is and the posterior covariance gives its band.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline
from scipy.optimize import minimize_scalar

from analysis.experiment import Protocol
from analysis.gap.data.groups import FEWEST, distinct_temperatures
from analysis.material import Material, MaterialLaws, MaterialSigma

KNOT_SPACING = 2.5
"""Spacing of knots, K: narrower than any transition of a polymer, so that only the penalty smooths."""


def fit_laws(
    temperature: NDArray[np.float64],
    material: Material,
    sigma: MaterialSigma,
    *,
    reading_sigma: float = 0.05 / np.sqrt(2.0),
    temperature_range: tuple[float, float] | None = None,
    common: NDArray[np.float64] | None = None,
) -> MaterialLaws:
    """Laws through estimates at `temperature`.

    Parameters
    ----------
    temperature : (T,) ndarray
        Degrees Celsius; may hold repeated values (up and down ramp).
    material, sigma : Material, MaterialSigma
        Estimates and standard deviations by their own noise, (T,) arrays.
    reading_sigma : float
        Standard deviation of a sweep's temperature reading, K; on a steep law it outweighs that of the
        estimates. The default is the mean of two readings with 0.05 K each.
    temperature_range : (float, float), optional
        Validity range of the laws, degrees Celsius; that of the data by default. May exceed the data only by the
        uncertainty of the readings.
    common : (T, 3, P) ndarray, optional
        Errors of log E, nu and log eta that the estimates share, one standard deviation of each of P causes: they
        widen the bands, and no smoothing takes them out.

    Raises
    ------
    ValueError
        For fewer than three different temperatures, or a range beyond the data.
    """
    distinct = distinct_temperatures(temperature)
    if distinct < FEWEST:
        raise ValueError(
            f"laws over temperature need at least {FEWEST} different temperatures; there are {distinct}"
        )
    low, high = temperature_range or (float(temperature.min()), float(temperature.max()))
    slack = 1.0
    if low < temperature.min() - slack or high > temperature.max() + slack:
        raise ValueError(
            f"the laws are asked for {low:g} to {high:g} °C; the data reach from {temperature.min():.2f} "
            f"to {temperature.max():.2f} °C, and laws are not extrapolated"
        )
    low, high = min(low, float(temperature.min())), max(high, float(temperature.max()))
    intervals = max(4, int(np.ceil((high - low) / KNOT_SPACING)))
    inner = np.linspace(low, high, intervals + 1)
    knots = np.concatenate([np.full(3, low), inner, np.full(3, high)])
    curves = [
        (np.log(material.youngs_modulus), sigma.youngs_modulus / material.youngs_modulus, True),
        (material.poisson_ratio, sigma.poisson_ratio, False),
        (np.log(material.loss_factor), sigma.loss_factor / material.loss_factor, False),
    ]
    shared = np.zeros((temperature.size, 3, 0)) if common is None else common
    fitted = [
        _fit_curve(knots, temperature, y, s, reading_sigma, falling, shared[:, law])
        for law, (y, s, falling) in enumerate(curves)
    ]
    return MaterialLaws(
        knots=knots,
        coefficients=np.array([c for c, _ in fitted]),
        covariance=np.array([v for _, v in fitted]),
        temperature_range=(low, high),
    )


def laws_of_sweeps(
    temperature: NDArray[np.float64],
    material: Material,
    sigma: MaterialSigma,
    settled: NDArray[np.bool_],
    protocol: Protocol,
    common: NDArray[np.float64] | None = None,
) -> MaterialLaws | None:
    """Laws through the settled estimates of a campaign's sweeps.

    Parameters
    ----------
    temperature : (T,) ndarray
        Degrees Celsius.
    material, sigma : Material, MaterialSigma
        Estimates and standard deviations, (T,) arrays.
    settled : (T,) ndarray of bool
        Which estimates count.
    protocol : Protocol
        Gives the range of temperatures.
    common : (T, 3, P) ndarray, optional
        As in `fit_laws`.

    Returns
    -------
    MaterialLaws or None
        None where the estimates cover fewer than three temperatures.
    """
    there = temperature[settled]
    if distinct_temperatures(there) < FEWEST:
        return None
    known = Material(*(row[settled] for row in vars(material).values()))
    spread = MaterialSigma(*(row[settled] for row in vars(sigma).values()))
    shared = None if common is None else common[settled]
    return fit_laws(there, known, spread, temperature_range=reached(protocol, there), common=shared)


def reached(protocol: Protocol, temperature: NDArray[np.float64]) -> tuple[float, float]:
    """Part of the protocol's temperature range that readings (T,) reached, degrees Celsius."""
    nominal, low, high = protocol.temperatures, float(temperature.min()), float(temperature.max())
    return min((t for t in nominal if t > low - 0.5), default=low), max(
        (t for t in nominal if t < high + 0.5), default=high
    )


def _fit_curve(
    knots: NDArray[np.float64],
    temperature: NDArray[np.float64],
    y: NDArray[np.float64],
    sigma: NDArray[np.float64],
    reading_sigma: float,
    falling: bool,
    common: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Coefficients of one law and their covariance; reading errors are included through the law's slope."""
    design = BSpline.design_matrix(temperature, knots, 3).toarray()
    size = design.shape[1]
    # differences over the Greville abscissae, because the coefficients are unevenly spaced at the ends
    sites = np.array([knots[i + 1 : i + 4].mean() for i in range(size)])
    first = np.diff(np.eye(size), axis=0) / np.diff(sites)[:, None]
    second = np.diff(first, axis=0)
    roughness = second.T @ second
    slope = np.gradient(np.interp(sites, *_sorted_means(temperature, y)), sites)
    coefficients, covariance = np.zeros(size), np.eye(size)
    for _ in range(3):
        variance = sigma**2 + (np.interp(temperature, sites, slope) * reading_sigma) ** 2
        coefficients, covariance = _smooth(design, y, variance, roughness, first if falling else None, common)
        slope = BSpline(knots, coefficients, 3).derivative()(sites)
    return coefficients, covariance


def _sorted_means(
    temperature: NDArray[np.float64], y: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Temperatures rounded to 0.1 K, ascending, with the mean of y at each."""
    sites, place = np.unique(np.round(temperature, 1), return_inverse=True)
    return sites, np.bincount(place, y) / np.bincount(place)


def _smooth(
    design: NDArray[np.float64],
    y: NDArray[np.float64],
    variance: NDArray[np.float64],
    roughness: NDArray[np.float64],
    falling: NDArray[np.float64] | None,
    common: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Penalised least squares with the penalty of maximum restricted likelihood.

    Where the residuals exceed `variance`, the covariance is inflated by their ratio. `falling` is the first
    difference operator of a law that may not rise: rising differences are pinned to zero.
    """
    weight = 1.0 / variance
    gram = design.T @ (weight[:, None] * design)
    moment = design.T @ (weight * y)
    rank = np.linalg.matrix_rank(roughness)
    freedom = max(len(y) - (len(roughness) - rank), 1)

    def solve(log_penalty: float) -> tuple[NDArray[np.float64], NDArray[np.float64], float, float]:
        matrix = gram + np.exp(log_penalty) * roughness
        coefficients = np.linalg.solve(matrix, moment)
        misfit = float(weight @ (y - design @ coefficients) ** 2)
        misfit += float(np.exp(log_penalty) * coefficients @ roughness @ coefficients)
        scale = max(misfit / freedom, 1.0)
        score = freedom * np.log(scale) + misfit / scale
        score += float(np.linalg.slogdet(matrix)[1]) - rank * log_penalty
        return coefficients.astype(np.float64), matrix, scale, float(score)

    centre = float(np.log(np.trace(gram) / np.trace(roughness)))
    best = minimize_scalar(lambda p: solve(p)[3], bounds=(centre - 10.0, centre + 18.0), method="bounded")
    coefficients, matrix, scale, _ = solve(float(best.x))
    if falling is not None:
        stiff = 1e8 * float(np.trace(gram) / np.trace(falling.T @ falling))
        for _ in range(20):
            rising = falling @ coefficients > 1e-12
            if not rising.any():
                break
            matrix = matrix + stiff * falling[rising].T @ falling[rising]
            coefficients = np.linalg.solve(matrix, moment).astype(np.float64)
    inverse = np.linalg.inv(matrix)
    carried = inverse @ (design.T @ (weight[:, None] * common))  # the fit is linear in the estimates
    return coefficients, (scale * inverse + carried @ carried.T).astype(np.float64)
