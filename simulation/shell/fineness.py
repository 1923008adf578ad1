"""Settings of the discretisation of a plate: mesh, degree and tolerance, by its shortest bending wave."""

from dataclasses import dataclass

import numpy as np

from analysis.experiment import Plate
from analysis.material import MaterialBox, Orthotropy
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.shell.rigidity import SHEAR_FACTOR, moduli

USUAL_LOSS = 0.025
"""Loss factor for which tolerances are stated: the middle of a thermoplastic's range."""
LEAST_TOLERANCE_FACTOR = 1e-3
"""Smallest factor on a tolerance, for any material."""


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


@dataclass(frozen=True)
class Fineness:
    """Mesh, degree of its functions, and tolerance of their selection.

    Attributes
    ----------
    mesh : MeshRecipe, optional
        Unless given, the usual one with cells small enough for the shortest wave, see `recipe`.
    degree : int
        Degree of the functions before the selection.
    tolerance : float
        Share of a response's energy from which a function is kept; 0 keeps all. With 3e-9 the error of transfers
        between patches is 0.01 to 0.03 % of their rms, with 1e-8 0.1 %. See `share`.
    """

    mesh: MeshRecipe | None = None
    degree: int = 7
    tolerance: float = 3e-9

    def __post_init__(self) -> None:
        if not 2 <= self.degree <= 12:
            raise ValueError(f"degree is {self.degree}; allowed 2 to 12")
        if not 0.0 <= self.tolerance <= 1e-2:
            raise ValueError(f"tolerance of functions is {self.tolerance:g}; allowed 0 to 0.01")

    def recipe(self, plate: Plate, box: MaterialBox, band: tuple[float, float]) -> MeshRecipe:
        """Return the sizes of a plate's mesh.

        Parameters
        ----------
        band : (float, float)
            Hz.
        """
        return self.mesh or MeshRecipe.of_plate(plate.area, plate.thickness, shortest_wave(plate, box, band))

    def share(self, box: MaterialBox) -> float:
        """Share of a response's energy from which a function is kept: smaller for materials with little damping.

        Functions left out shift resonances. The error of a transfer is this shift over the width of a resonance,
        and plates with few, sharp resonances need more functions for the same shift: the share goes with the
        square of the loss factor. A plate of aluminium with two patches, loss factor 0.2 %, has an error of 0.5 %
        of the rms with a share in proportion to the loss factor, and of 0.05 % with its square.
        """
        return self.tolerance * min(1.0, max(relative_loss(box) ** 2, LEAST_TOLERANCE_FACTOR))


def relative_loss(box: MaterialBox) -> float:
    """Middle of a material's loss factors, over that for which tolerances are stated."""
    low, high = box.loss_factor
    return float((low * high) ** 0.5) / USUAL_LOSS
