"""Measures of radiated sound: efficiency, directivity, level, group delay; errors by the noise of a scan.

Third-octave bands are those of IEC 61260-1, base ten.
"""

import numpy as np

from analysis.arrays import Complex, Real
from analysis.radiation.radiator import Radiator, SourceNodes

REFERENCE_PRESSURE = 2e-5
"""Pa, of the sound pressure level (ISO 1683)."""


def hemisphere(order: int) -> tuple[Real, Real]:
    """Directions in front of a panel, with weights for integrals over the half sphere.

    Gauss-Legendre points in the cosine of the polar angle and even steps of the azimuth: exact for polynomials of
    degree 2 `order` - 1.

    Parameters
    ----------
    order : int
        Number of polar angles; there are twice as many azimuths.

    Returns
    -------
    directions : (2 order², 3) ndarray
        Unit vectors.
    weight : (2 order²,) ndarray
        Their sum is 2π.
    """
    place, weight = np.polynomial.legendre.leggauss(order)
    cosine, share = 0.5 * (place + 1.0), 0.5 * weight
    azimuth = np.pi * (np.arange(2 * order) + 0.5) / order
    polar = np.sqrt(1.0 - cosine**2)
    directions = np.stack(
        [
            np.outer(polar, np.cos(azimuth)),
            np.outer(polar, np.sin(azimuth)),
            np.broadcast_to(cosine[:, None], (order, 2 * order)),
        ],
        axis=-1,
    )
    return directions.reshape(-1, 3), np.repeat(share * np.pi / order, 2 * order)


def arc(degrees: Real, azimuth: float = 0.0) -> Real:
    """Directions (D, 3) on an arc over a panel, at `degrees` (D,) from its normal, in the plane of an `azimuth`.

    Azimuth 0 is the plane of x and the normal, 90 degrees that of y; positive angles are toward +x or +y.
    """
    polar, around = np.deg2rad(np.asarray(degrees, dtype=float)), np.deg2rad(azimuth)
    return np.stack([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)], axis=-1)


def far_power(radiator: Radiator, field: Complex, frequency: Real, order: int = 24) -> Real:
    """Radiated power by integration of the far field, independent of the quadratic form.

    Parameters
    ----------
    field : (F, K) ndarray
        Displacement at the points, m.
    frequency : (F,) ndarray, Hz
    order : int
        See `hemisphere`.

    Returns
    -------
    (F,) ndarray
        W.
    """
    directions, weight = hemisphere(order)
    both = 2.0 * np.pi / radiator.solid_angle  # a box radiates backward what it radiates forward
    found = []
    for here, displacement in zip(np.asarray(frequency, dtype=float), field, strict=True):
        pressure = radiator.far_field(directions, np.array([here]))[:, 0] @ displacement
        intensity = np.abs(pressure) ** 2 / (2.0 * radiator.air.density * radiator.air.sound_speed)
        found.append(float(weight @ intensity) / both)
    return np.array(found)


def radiation_efficiency(radiator: Radiator, power: Real, field_energy: Real, frequency: Real) -> Real:
    """Radiation efficiency σ = W / (ρ c ∫ v²/2 dS).

    Parameters
    ----------
    power : (F,) ndarray
        W.
    field_energy : (F,) ndarray
        ∫ |U|² dS over the plate, m4.
    frequency : (F,) ndarray, Hz

    Returns
    -------
    (F,) ndarray
        NaN where the plate is at rest.
    """
    omega = 2.0 * np.pi * np.asarray(frequency, dtype=float)
    moving = 0.5 * radiator.air.density * radiator.air.sound_speed * omega**2 * field_energy
    return np.asarray(np.divide(power, moving, out=np.full(len(omega), np.nan), where=moving > 0.0))


def directivity_index(radiator: Radiator, on_axis: Complex, power: Real) -> Real:
    """Directivity index, dB: intensity on the axis over that of the same power spread evenly over all directions.

    Parameters
    ----------
    on_axis : (F,) ndarray
        Pressure on the axis far away, times the distance, Pa m.
    power : (F,) ndarray
        W.

    Returns
    -------
    (F,) ndarray
        A small source in a baffle has 3 dB.
    """
    air = radiator.air
    axial = np.abs(on_axis) ** 2 / (2.0 * air.density * air.sound_speed)
    return np.asarray(10.0 * np.log10(np.maximum(axial * 4.0 * np.pi / power, 1e-30)))


def sound_pressure_level(pressure: Complex) -> Real:
    """Level (...) of pressure amplitudes, Pa: dB re 20 µPa of the root mean square."""
    return np.asarray(20.0 * np.log10(np.maximum(np.abs(pressure), 1e-12) / np.sqrt(2.0) / REFERENCE_PRESSURE))


def group_delay(response: Complex, frequency: Real) -> Real:
    """Group delay -dφ/dω (..., F), s, of a `response` (..., F) at evenly spaced `frequency` (F,), Hz."""
    phase = np.unwrap(np.angle(response), axis=-1)
    return np.asarray(-np.gradient(phase, 2.0 * np.pi * frequency, axis=-1))


FEWEST_LINES = 3
"""Lines in a band, for which its mean is taken."""


def third_octaves(frequency: Real) -> tuple[Real, Real]:
    """Bands whose middle lies within a set of lines.

    Parameters
    ----------
    frequency : (F,) ndarray, Hz
        Ascending.

    Returns
    -------
    middle : (B,) ndarray, Hz
    member : (B, F) ndarray of bool
        Which lines each band has, at least three.
    """
    first, last = np.ceil(10.0 * np.log10(frequency[0])), np.floor(10.0 * np.log10(frequency[-1]))
    middle = 10.0 ** (np.arange(first, last + 1.0) / 10.0)
    half = 10.0**0.05
    member = (frequency >= middle[:, None] / half) & (frequency < middle[:, None] * half)
    held = member.sum(axis=1) >= FEWEST_LINES
    return middle[held], member[held]


def third_octave_levels(response: Complex, frequency: Real) -> Real:
    """Level of a response in third-octave bands.

    Parameters
    ----------
    response : (..., F) ndarray
        Relative to what is wanted.
    frequency : (F,) ndarray, Hz

    Returns
    -------
    (..., B) ndarray
        dB of the mean square over the lines of each band.
    """
    _, member = third_octaves(frequency)
    squares = np.abs(response) ** 2 @ (member / member.sum(axis=1, keepdims=True)).T
    return np.asarray(10.0 * np.log10(np.maximum(squares, 1e-20)))


def ripple(response: Complex, frequency: Real) -> Real:
    """Ripple (...), ± dB: half the difference of the loudest and the softest third-octave band.

    Of lines where none of the bands lies within `frequency`.
    """
    levels = third_octave_levels(response, frequency)
    if not levels.shape[-1]:
        levels = 20.0 * np.log10(np.maximum(np.abs(response), 1e-10))
    return np.asarray(0.5 * np.ptp(levels, axis=-1))


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
