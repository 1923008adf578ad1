"""What the noise of a scan makes of pressure and power computed from it."""

import numpy as np

from analysis.arrays import Complex, Real
from analysis.radiation.radiator import SourceNodes


def driven_variance(variance: Real, filters: Complex) -> Real:
    """Variance (F, K) of the field of `filters` (F, N), from that of the transfers (N, F, K): Σ |R|² σ²."""
    return np.asarray(np.einsum("fn,nfk->fk", np.abs(filters) ** 2, variance))


def pressure_sigma(kernel: Complex, variance: Real) -> Real:
    """Return the standard deviation of pressures.

    Parameters
    ----------
    kernel : (L, F, K) ndarray
        `Radiator.pressure`.
    variance : (F, K) ndarray
        Of the field at the points, E|error|², m2. Errors of different points are independent.

    Returns
    -------
    (L, F) ndarray
        √E|error|², Pa.
    """
    return np.asarray(np.sqrt(np.einsum("lfk,fk->lf", np.abs(kernel) ** 2, variance)))


def power_error(sources: SourceNodes, field: Complex, variance: Real, frequency: Real) -> tuple[Real, Real]:
    """Bias and standard deviation of the power computed from a noisy field.

    Parameters
    ----------
    field : (F, K) ndarray
        As measured, m.
    variance : (F, K) ndarray
        E|error|², m2.
    frequency : (F,) ndarray, Hz

    Returns
    -------
    bias : (F,) ndarray
        By which the power is overestimated on average, W; to be subtracted.
    sigma : (F,) ndarray
        W.

    Notes
    -----
    For W = xᴴ A x with x = u + e, e circular Gaussian of covariance S: bias tr(A S), variance
    2 uᴴ A S A u + tr(A S A S). Seen in x the first term contains the second twice, which makes σ a little too
    large where noise exceeds the field, never too small.
    """
    bias, sigma = [], []
    for here, displacement, spread in zip(np.asarray(frequency, dtype=float), field, variance, strict=True):
        resistance = sources.resistance(float(here))
        noise = resistance @ ((sources.lumped * spread) @ sources.lumped.T)
        image = resistance @ (sources.lumped @ displacement)
        through = float(np.sum(np.abs(sources.lumped.T @ image) ** 2 * spread))
        bias.append(float(np.trace(noise)))
        sigma.append(float(np.sqrt(2.0 * through + np.sum(noise * noise.T))))
    return np.array(bias), np.array(sigma)
