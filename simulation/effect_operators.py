"""Reduced matrices from which a plate in any state is composed."""

from dataclasses import dataclass, fields, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from analysis.material import MaterialBox

Real = NDArray[np.float64]

BENDING_DEGREE, MEMBRANE_DEGREE = 2, 1
"""Total degrees of the fields that multiply bending energy, and membrane, shear and inertia.

A taper of 5 % or a gradient of 8 K leaves 1e-4 of the local bending stiffness beyond degree 2, and in-plane and
shear energies matter through patches and corrections only.
"""


OFFSET_DEGREE = 4
"""Total degree of what an offset of the sensor does, as a polynomial."""


def monomials(x: Any, y: Any) -> NDArray[Any]:
    """Products of powers of x and y with total degree 1 to `OFFSET_DEGREE`."""
    return np.array([x ** (n - j) * y**j for n in range(1, OFFSET_DEGREE + 1) for j in range(n + 1)])


@dataclass(frozen=True)
class EffectOperators:
    """Real symmetric (r, r) matrices, one stack for each kind of field.

    Coordinates are those of `vectors`; the mass of the plate as declared is close to the identity.

    Attributes
    ----------
    bending, membrane : (4, terms, r, r) ndarray
        Energies of Q11, Q22, Q12, Q66 with every polynomial, for a modulus of 1 Pa and the nominal thickness.
    shear : (terms, r, r) ndarray
        Transverse shear energy for G = 1 Pa, shear factor included.
    mass, rotary : (terms, r, r) ndarray
        Inertia of the plate as declared, per unit field: of displacements, of rotations.
    normal : (r, r) ndarray
        Integral of w times w, m2.
    patch_own : (r, r) ndarray
        Bending about their own mid-height and shear of all patches, N/m.
    patch_membrane : (1 + 2 terms, r, r) ndarray
        Membrane stiffness of all patches at their mid-height: as declared, then the factors of tau (plate
        thickness over nominal less 1) and of tau squared, polynomial by polynomial.
    patch_mass : (r, r) ndarray
    coupling : (1 + terms, r, P) ndarray
        Of every patch: as declared, and the factors of tau.
    capacitance : (P,) ndarray
    offset_bending, offset_membrane : (4, monomials, r, r) ndarray
        Change of the energies around the first sensor with its offset, for moduli of 1 Pa; ``offset_shear`` and
        ``offset_mass`` (monomials, r, r) likewise.
    sensor_site : (terms,) ndarray
        The polynomials at the first sensor's declared place.
    strain : (8, N, r) ndarray
        Strains of every coordinate at points over the plate: membrane x, y, xy; curvature x, y, xy; transverse
        shear x, y. They weigh what changes on a spot smaller than any polynomial.
    strain_points : (N, 2) ndarray
        m; the middles of equal cells that cover the plate.
    cell : float
        Area of a cell, m2.
    thickness : float
        Of the plate, m.
    points : (K, 2) ndarray
        Where point loads can act, m.
    deflection : (K, r) ndarray
        w there.
    box : MaterialBox
    band : (float, float)
        Hz.
    offset_range : float
        Largest offset along x or y, m.
    error : float
        Largest error of any transfer between patches, over its rms along the band, against the full model in
        states at the edges of the certified ranges.
    """

    bending: Real
    membrane: Real
    shear: Real
    mass: Real
    rotary: Real
    normal: Real
    patch_own: Real
    patch_membrane: Real
    patch_mass: Real
    coupling: Real
    capacitance: Real
    offset_bending: Real
    offset_membrane: Real
    offset_shear: Real
    offset_mass: Real
    sensor_site: Real
    strain: Real
    strain_points: Real
    cell: float
    thickness: float
    points: Real
    deflection: Real
    box: MaterialBox
    band: tuple[float, float]
    offset_range: float
    error: float

    def __post_init__(self) -> None:
        for entry in fields(self):
            value = getattr(self, entry.name)
            if isinstance(value, np.ndarray) and not np.isfinite(value).all():
                raise ValueError(f"effect operators: {entry.name} holds values that are not finite")

    @property
    def size(self) -> int:
        """Number of coordinates r."""
        return len(self.normal)

    def restricted(self, basis: Real) -> Self:
        """Galerkin model on the columns of `basis` (r, s); same ranges and stated error."""
        stacks: dict[str, Any] = {}
        for entry in fields(self):
            value = getattr(self, entry.name)
            if isinstance(value, np.ndarray) and value.ndim >= 2 and value.shape[-2:] == (self.size, self.size):
                stacks[entry.name] = basis.T @ value @ basis
        return replace(
            self,
            **stacks,
            coupling=basis.T @ self.coupling,
            strain=self.strain @ basis,
            deflection=self.deflection @ basis,
        )
