"""In-plane stiffness of a layer along the plate's axes, and the moduli in which a plate's stiffness is affine."""

import numpy as np

from analysis.declaration.plate_material import Orthotropy
from simulation.shell.rigidity import Weight

InPlane = tuple[Weight, Weight, Weight, Weight, Weight, Weight]
"""Q11, Q22, Q12, Q66, Q16, Q26 of a layer, Pa."""
Transverse = tuple[Weight, Weight, Weight]
"""Transverse shear stiffness of the strains xz and yz, and of both together, Pa."""


def moduli(
    sheet: Orthotropy, c1: Weight, c2: Weight, x: Weight = 1.0, y: Weight = 1.0, shear: Weight = 1.0
) -> InPlane:
    """Stiffness Q of a sheet along the plate's axes.

    Parameters
    ----------
    sheet : Orthotropy
        As declared.
    c1, c2 : float or ndarray
        E/(1 - nu**2) and nu times that, Pa: numbers, or one for every cell or point of quadrature.
    x, y, shear : float or ndarray
        Factors on E_x, E_y and the in-plane shear modulus in the sheet's own axes, in addition to its declared
        orthotropy.

    Returns
    -------
    tuple of six
        Q11, Q22, Q12, Q66, Q16 and Q26, Pa.
    """
    x, y, shear = (1.0 - sheet.delta_e) * x, (1.0 + sheet.delta_e) * y, (1.0 + sheet.delta_g) * shear
    own = (c1 * x, c1 * y, c2 * (x * y) ** 0.5, 0.5 * (c1 - c2) * shear)
    return (*own, 0.0, 0.0) if sheet.angle == 0.0 else _turned(own, sheet.angle)


def matrix(q: InPlane) -> list[list[Weight]]:
    """Q as a matrix (3, 3) over the strains xx, yy and xy."""
    q11, q22, q12, q66, q16, q26 = q
    return [[q11, q12, q16], [q12, q22, q26], [q16, q26, q66]]


def transverse(sheet: Orthotropy, shear: Weight, x: Weight = 1.0, y: Weight = 1.0) -> Transverse:
    """Transverse shear stiffness of a sheet along the plate's axes.

    Parameters
    ----------
    sheet : Orthotropy
        As declared.
    shear : float or ndarray
        E/2(1 + nu), Pa.
    x, y : float
        Factors on the moduli of the planes xz and yz in the sheet's own axes.

    Returns
    -------
    tuple of three
        Of the strains xz and yz, and of both together, Pa.
    """
    first, second = x * sheet.transverse[0], y * sheet.transverse[1]
    c, s = float(np.cos(sheet.angle)), float(np.sin(sheet.angle))
    if sheet.angle == 0.0:
        return first * shear, second * shear, 0.0
    return (
        (c * c * first + s * s * second) * shear,
        (s * s * first + c * c * second) * shear,
        c * s * (first - second) * shear,
    )


def _turned(own: tuple[Weight, Weight, Weight, Weight], angle: float) -> InPlane:
    """Q of a layer whose own axes are turned by `angle` (Jones, Mechanics of Composite Materials, eq. 2.80)."""
    q11, q22, q12, q66 = own
    c, s = float(np.cos(angle)), float(np.sin(angle))
    mixed = q12 + 2.0 * q66
    return (
        c**4 * q11 + 2.0 * c * c * s * s * mixed + s**4 * q22,
        s**4 * q11 + 2.0 * c * c * s * s * mixed + c**4 * q22,
        c * c * s * s * (q11 + q22 - 4.0 * q66) + (c**4 + s**4) * q12,
        c * c * s * s * (q11 + q22 - 2.0 * q12 - 2.0 * q66) + (c**4 + s**4) * q66,
        c**3 * s * (q11 - mixed) - c * s**3 * (q22 - mixed),
        c * s**3 * (q11 - mixed) - c**3 * s * (q22 - mixed),
    )


def plane_stress_moduli(youngs_modulus: float, poisson_ratio: float) -> tuple[float, float]:
    """C1 = E/(1 - nu**2) and C2 = nu C1, Pa: the stiffness is affine in these two."""
    c1 = youngs_modulus / (1.0 - poisson_ratio**2)
    return c1, poisson_ratio * c1
