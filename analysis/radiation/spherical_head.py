"""Sound at the ears of a listener whose head is a rigid sphere.

R. O. Duda, W. L. Martens, Range dependence of the response of a spherical head model, JASA 104 (1998) 3048: the
pressure on a rigid sphere of radius a from a point source at distance r, over that at the place of its centre
without the sphere, with the time convention exp(+jωt), x = ka and ρ = r/a:

    H = -(ρ/x) exp(jxρ) Σ_m (2m + 1) P_m(cos θ) h_m⁽²⁾(xρ) / h_m⁽²⁾'(x),

θ between the ear and the source. No pinna, no torso: enough for interaural differences below about 1.5 kHz.
"""

import numpy as np
from scipy.special import eval_legendre, spherical_jn, spherical_yn

from analysis.arrays import Complex, Real

HEAD_RADIUS = 0.0875
"""m, of an average adult."""
SERIES_TERMS = 10
"""Terms of the series beyond x: those left out are below 1e-8 for sources farther than twice the radius."""


def sphere_response(cosine: Real, distance: float, wavenumber: Real, radius: float = HEAD_RADIUS) -> Complex:
    """Pressure at an ear over that at the head's centre without the head.

    Parameters
    ----------
    cosine : (A,) ndarray
        Of the angle between ear and source.
    distance : float
        Of the source from the head's centre, m; more than the radius.
    wavenumber : (F,) ndarray, 1/m
        Above 0.
    radius : float
        Of the head, m.

    Returns
    -------
    (A, F) complex ndarray

    Raises
    ------
    ValueError
        For a source in the head.
    """
    if distance <= radius:
        raise ValueError(
            f"a source {distance:g} m from the middle of a head of {radius:g} m; allowed: farther away"
        )
    x, away = np.asarray(wavenumber) * radius, distance / radius
    total = np.zeros((len(cosine), len(x)), dtype=complex)
    for m in range(int(np.ceil(x.max())) + SERIES_TERMS):
        outgoing = spherical_jn(m, x * away) - 1j * spherical_yn(m, x * away)
        slope = spherical_jn(m, x, derivative=True) - 1j * spherical_yn(m, x, derivative=True)
        total += (2 * m + 1) * eval_legendre(m, cosine)[:, None] * (outgoing / slope)
    return np.asarray(-(away / x) * np.exp(1j * x * away) * total)


def at_ears(kernel: Complex, points: Real, position: Real, wavenumber: Real) -> Complex:
    """Turn the pressure of every element at a head's place into that at its two ears.

    Parameters
    ----------
    kernel : (F, K) ndarray
        `Radiator.pressure` at the middle of the head.
    points : (K, 2) ndarray
        Of the panel, m.
    position : (3,) ndarray
        Middle of the head, m. It looks straight at the panel's plane, y upward: the right ear is toward +x.
    wavenumber : (F,) ndarray, 1/m

    Returns
    -------
    (2, F, K) complex ndarray
        Left, right. Distances of the elements are taken as that of their mean: they differ little as seen from a
        head; angles are each element's own.
    """
    way = np.column_stack([points, np.zeros(len(points))]) - position
    distance = np.linalg.norm(way, axis=1)
    angles = np.linspace(-1.0, 1.0, 65)
    table = sphere_response(angles, float(distance.mean()), wavenumber)
    ears = []
    for side in (-1.0, 1.0):
        cosine = side * way[:, 0] / distance
        real, imaginary = (
            np.array([np.interp(cosine, angles, row) for row in part.T]) for part in (table.real, table.imag)
        )
        ears.append(kernel * (real + 1j * imaginary))
    return np.array(ears)
