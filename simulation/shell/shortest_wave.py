"""The shortest bending wave of a plate within its material's range and its band."""

import numpy as np

from analysis.experiment import Plate
from analysis.material import MaterialBox
from simulation.shell.shear_factor import SHEAR_FACTOR


def shortest_wave(plate: Plate, box: MaterialBox, band: tuple[float, float]) -> float:
    """Wavelength of free bending waves at the band's upper end, in the softest material and the thinnest part.

    Parameters
    ----------
    plate : Plate
    box : MaterialBox
        Its lowest modulus and Poisson's ratio give the softest plate; a declared orthotropy softens it further.
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
    departure = plate.material.departure if plate.material is not None else None
    weaker = 1.0 - abs(departure.delta_e) if departure is not None else 1.0
    e, nu = weaker * box.youngs_modulus[0], box.poisson_ratio[0]
    h = min([plate.thickness, *(zone.thickness for zone in plate.zone)])
    omega2 = (2.0 * np.pi * band[1]) ** 2
    bending, shear = e * h**3 / 12.0 / (1.0 - nu**2), SHEAR_FACTOR * h * 0.5 * e / (1.0 + nu)
    mass, rotary = plate.density * h, plate.density * h**3 / 12.0
    half = 0.5 * (rotary / bending + mass / shear) * omega2
    rest = mass * omega2 / bending * (1.0 - rotary * omega2 / shear)
    return float(2.0 * np.pi / np.sqrt(half + np.sqrt(half**2 + rest)))
