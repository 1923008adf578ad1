"""The shortest bending wave of a plate within its material's range and its band."""

import numpy as np

from analysis.experiment import Plate
from analysis.material import MaterialBox
from analysis.sheet_orthotropy import Orthotropy
from simulation.shell.in_plane import moduli
from simulation.shell.shear_factor import SHEAR_FACTOR


def shortest_wave(plate: Plate, box: MaterialBox, band: tuple[float, float]) -> float:
    """Wavelength of free bending waves at the band's upper end, in the softest material and the thinnest part.

    Parameters
    ----------
    box : MaterialBox
        Its lowest modulus and Poisson's ratio give the softest plate; of an orthotropic one the softest of all
        directions counts.
    band : (float, float)
        Hz.

    Returns
    -------
    float
        m.

    Notes
    -----
    The wavenumber k solves S D k^4 - (S I + m D) w^2 k^2 - m w^2 (S - I w^2) = 0 with the bending stiffness D,
    shear stiffness S, mass m and rotary inertia I of a plate per area (R. D. Mindlin, J. Appl. Mech. 18 (1951)
    31-38).
    """
    e, nu = box.youngs_modulus[0], box.poisson_ratio[0]
    in_plane, across = e / (1.0 - nu**2), 0.5 * e / (1.0 + nu)
    departure = plate.material.departure if plate.material is not None else None
    if departure is not None:
        in_plane, across = _softest(departure, in_plane, nu), min(departure.transverse) * across
    h = min([plate.thickness, *(zone.thickness for zone in plate.zone)])
    omega2 = (2.0 * np.pi * band[1]) ** 2
    bending, shear = in_plane * h**3 / 12.0, SHEAR_FACTOR * h * across
    mass, rotary = plate.density * h, plate.density * h**3 / 12.0
    half = 0.5 * (rotary / bending + mass / shear) * omega2
    rest = mass * omega2 / bending * (1.0 - rotary * omega2 / shear)
    return float(2.0 * np.pi / np.sqrt(half + np.sqrt(half**2 + rest)))


def _softest(sheet: Orthotropy, c1: float, poisson_ratio: float) -> float:
    """Least stiffness to the curvature of a plane wave, over all its directions, Pa."""
    q11, q22, q12, q66, q16, q26 = moduli(sheet, c1, poisson_ratio * c1)
    c, s = np.cos(DIRECTIONS), np.sin(DIRECTIONS)
    stiffness = c**4 * q11 + 2.0 * c * c * s * s * (q12 + 2.0 * q66) + s**4 * q22
    return float(np.min(stiffness + 4.0 * c * s * (c * c * q16 + s * s * q26)))


DIRECTIONS = np.arange(90) * (np.pi / 90)
"""Of waves, rad."""
