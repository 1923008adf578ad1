"""One verification case: a plate with known natural frequencies."""

from dataclasses import dataclass
from functools import cached_property
from typing import Literal, Protocol

import numpy as np

from analysis.arrays import Real
from analysis.geometry.loop import Loop


class ExactPlate(Protocol):
    """An exact solution: `Disc`, `HardRectangle` or `LevyPlate`."""

    def lowest(self, count: int) -> Real:
        """Lowest `count` frequencies w a**2 sqrt(rho h / D), ascending."""
        ...


@dataclass(frozen=True)
class CaseMaterial:
    """An isotropic material.

    Attributes
    ----------
    youngs_modulus : float
        Pa.
    poisson_ratio : float
    density : float
        kg/m3.
    """

    youngs_modulus: float
    poisson_ratio: float
    density: float


Support = Literal["free", "clamped", "soft", "hard"]
"""``soft``: w = 0; ``hard``: the rotation along the edge too; ``clamped``: w and both rotations."""

CONDITIONS: dict[Support, tuple[str, str, str]] = {
    "free": ("shear force", "bending moment", "twisting moment"),
    "clamped": ("deflection", "rotation across", "rotation along"),
    "soft": ("deflection", "bending moment", "twisting moment"),
    "hard": ("deflection", "bending moment", "rotation along"),
}
"""Quantities that vanish at an edge."""
RIGID_FREQUENCY = 0.02
"""Frequency w a**2 sqrt(rho h / D) below which a motion counts as rigid."""


@dataclass(frozen=True)
class Case:
    """A plate, its supports, and its natural frequencies of bending.

    Attributes
    ----------
    name : str
        Lower case with hyphens; used in file names.
    title : str
    outline : Loop
        m.
    thickness : float
        m.
    material : CaseMaterial
    supports : tuple of Support
        Of every curve of the outline, in its order.
    known : tuple of float or ExactPlate
        Lowest frequencies, ascending, rigid motions left out; in Hz, or as w a**2 sqrt(rho h / D).
    length : float or None
        a, m, where `known` is without unit; None where it is in Hz.
    kind : str
        ``exact`` solution of the Mindlin plate, or ``converged`` values of a finite-element solution.
    tolerance : float
        Largest relative error allowed; not below the accuracy of `known`.
    source : str
    holes : tuple of Loop
        m.
    hole_supports : tuple of tuple of Support
        Of every curve of every hole.
    count : int
        Number of frequencies of an exact solution that are compared.
    published : tuple of float
        Published values, of thin plates or coarse elements, shown with `known` in the same unit.
    """

    name: str
    title: str
    outline: Loop
    thickness: float
    material: CaseMaterial
    supports: tuple[Support, ...]
    known: tuple[float, ...] | ExactPlate
    length: float | None
    kind: Literal["exact", "converged"]
    tolerance: float
    source: str
    holes: tuple[Loop, ...] = ()
    hole_supports: tuple[tuple[Support, ...], ...] = ()
    count: int = 8
    published: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if len(self.holes) != len(self.hole_supports):
            raise ValueError(f"{self.name}: {len(self.holes)} holes, supports of {len(self.hole_supports)}")
        for loop, supports in self.loops:
            if len(loop.curves) != len(supports):
                raise ValueError(f"{self.name}: {len(loop.curves)} curves, supports of {len(supports)}")
            for support in supports:
                if support not in CONDITIONS:
                    raise ValueError(f"{self.name}: support is {support!r}; allowed: {', '.join(CONDITIONS)}")
        if not 0.0 < self.tolerance < 0.1:
            raise ValueError(f"{self.name}: tolerance is {self.tolerance:g}; allowed above 0, below 0.1")

    @property
    def loops(self) -> tuple[tuple[Loop, tuple[Support, ...]], ...]:
        """Outline and holes, each with the supports of its curves."""
        return ((self.outline, self.supports), *zip(self.holes, self.hole_supports, strict=True))

    @property
    def area(self) -> float:
        """Area of the plate without its holes, m2."""
        return self.outline.area - sum(hole.area for hole in self.holes)

    @property
    def rigidity(self) -> float:
        """Flexural rigidity D, N m."""
        m = self.material
        return m.youngs_modulus * self.thickness**3 / (12.0 * (1.0 - m.poisson_ratio**2))

    @property
    def unit(self) -> float:
        """Unit of `known`, Hz."""
        if self.length is None:
            return 1.0
        mass = self.material.density * self.thickness
        return float(np.sqrt(self.rigidity / mass)) / (2.0 * np.pi * self.length**2)

    @cached_property
    def reference(self) -> Real:
        """Lowest frequencies, rigid motions left out, Hz, ascending, (K,)."""
        known = np.array(self.known) if isinstance(self.known, tuple) else self.known.lowest(self.count)
        return np.asarray(self.unit * known)

    @property
    def rigid_motions(self) -> int:
        """Number of independent rigid motions w = c0 + c1 x + c2 y that the supports allow."""
        rows = []
        for loop, supports in self.loops:
            for curve, support in zip(loop.curves, supports, strict=True):
                if support == "free":
                    continue
                x, y = (curve.at(np.linspace(0.0, 1.0, 5)) / np.sqrt(self.outline.area)).T
                rows.append(np.stack([np.ones(5), x, y], axis=1))
                if support == "clamped":
                    rows.append(np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]))
        return 3 - int(np.linalg.matrix_rank(np.vstack(rows), tol=1e-9)) if rows else 3
