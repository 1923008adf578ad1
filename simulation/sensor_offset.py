"""What moving the first sensor patch changes, as polynomials of its offset in reduced coordinates.

The mesh moves with the patch: shear layers at its edges stay on the strips made for them, the patch's own matrices
do not change at all, and those of the elements around it are smooth functions of the offset.
"""

from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from simulation.effect_operators import BENDING_DEGREE, OFFSET_DEGREE, ZONE_DEGREES, monomials
from simulation.effect_projection import Projector, weighed_energies
from simulation.field_basis import polynomial, polynomials
from simulation.shape_space import ShapeSpace
from simulation.state_matrices import FullPlate

Real = NDArray[np.float64]
Mask = NDArray[np.bool_]

OFFSET_RANGE = 0.0025
"""How far the first sensor patch can sit off its place along x or y, m."""
KEPT = 1e-4
"""Motions of the elements around the sensor weaker than this share of the strongest are left out."""


@dataclass(frozen=True)
class Zone:
    """The elements that stretch when the sensor moves.

    Attributes
    ----------
    elements : (elements,) bool ndarray
    middle : (float, float)
        xi and zeta of their centre of area.
    """

    elements: Mask
    middle: tuple[float, float]

    @classmethod
    def of(cls, full: FullPlate) -> "Zone":
        """Look what a small offset changes."""
        mesh = full.space.basis.mesh
        moved = full.moved_by(1e-3 * OFFSET_RANGE, 1e-3 * OFFSET_RANGE).space.basis.mesh
        elements = np.asarray((mesh.p != moved.p).any(axis=0)[mesh.t].any(axis=0))
        area = np.where(elements[:, None], full.space.basis.dx, 0.0).ravel()
        xi, zeta = (float(np.average(place, weights=area)) for place in full.sampling)
        return cls(elements, (xi, zeta))

    def power(self, degrees: tuple[int, int], full: FullPlate) -> Real:
        """Product of powers of xi and zeta about the middle at the quadrature points, (elements, points)."""
        xi, zeta = (place - middle for place, middle in zip(full.sampling, self.middle, strict=True))
        return np.asarray(xi ** degrees[0] * zeta ** degrees[1]).reshape(full.space.basis.dx.shape)

    def fit(self, full: FullPlate) -> Real:
        """Return ``zone_fit`` of `EffectOperators`."""
        root = np.sqrt(full.space.basis.dx[self.elements]).ravel()
        xi, zeta = (place.reshape(full.space.basis.dx.shape)[self.elements].ravel() for place in full.sampling)
        powers = [self.power(degrees, full)[self.elements].ravel() for degrees in _powers()]
        fields = [polynomial(degrees, xi, zeta) for degrees in polynomials(BENDING_DEGREE)]
        return np.asarray(np.linalg.lstsq((root * np.array(powers)).T, (root * np.array(fields)).T)[0])


def can_move(full: FullPlate) -> bool:
    """Whether the first sensor has room for offsets up to `OFFSET_RANGE`, and no other patch stretches with it."""
    try:
        for x in (-OFFSET_RANGE, OFFSET_RANGE):
            for y in (-OFFSET_RANGE, OFFSET_RANGE):
                full.moved_by(x, y)
    except ValueError:
        return False
    zone = Zone.of(full).elements
    return not any((zone & under).any() for k, under in enumerate(full.under) if k != full.moved)


def offset_energies(p: Projector, executor: Executor) -> dict[str, object]:
    """Stacks ``offset_*`` of `EffectOperators`, fitted over a grid of offsets; zero where it cannot move."""
    if not can_move(p.full):
        return _unmoved(p.vectors.shape[1])
    zone = Zone.of(p.full)
    near, motions = _around(p, zone)
    origin = _energies(near, near.full.space, zone)
    places = padua_points(OFFSET_DEGREE)
    spaces = [p.full.moved_by(OFFSET_RANGE * x, OFFSET_RANGE * y).space for x, y in places]
    moved = list(executor.map(lambda space: _energies(near, space, zone), spaces))
    fit = np.linalg.pinv(np.array([monomials(x, y) for x, y in places]))
    found: dict[str, object] = {"zone": motions, "zone_fit": zone.fit(p.full), "offset_range": OFFSET_RANGE}
    for name, start in origin.items():
        change = np.tensordot(fit, np.array([energies[name] - start for energies in moved]), 1)
        found[f"offset_{name}"] = np.moveaxis(change, 0, -3)
    return found


def padua_points(degree: int) -> list[tuple[float, float]]:
    """Points of a square that determine polynomials of a total degree (Caliari et al., AMC 165, 2005)."""
    x = np.cos(np.pi * np.arange(degree + 1) / degree)
    y = np.cos(np.pi * np.arange(degree + 2) / (degree + 1))
    return [(float(x[i]), float(y[j])) for i in range(x.size) for j in range(y.size) if (i + j) % 2 == 0]


def _powers() -> list[tuple[int, int]]:
    return polynomials(max(ZONE_DEGREES.values()))


def _unmoved(size: int) -> dict[str, object]:
    """Return the stacks of a sensor that stays where it is."""
    found: dict[str, object] = {
        "zone": np.zeros((0, size)),
        "zone_fit": np.zeros((len(_powers()), len(polynomials(BENDING_DEGREE)))),
        "offset_range": 0.0,
    }
    for name, degree in ZONE_DEGREES.items():
        moduli = (4,) if name in ("bending", "membrane") else ()
        shape = (*moduli, len(polynomials(degree)), len(monomials(0.0, 0.0)), 0, 0)
        found[f"offset_{name}"] = np.zeros(shape)
    return found


def _around(p: Projector, zone: Zone) -> tuple[Projector, Real]:
    """Vectors (n, q) of the leading motions in the zone, and the reduced coordinates' shares in them (q, r)."""
    energies = _weighed(p, p.full.space, zone, (0, 0))
    in_plane = energies["bending"] + energies["membrane"]
    elastic = in_plane[0] + in_plane[1] + 0.5 * in_plane[3] + energies["shear"]  # moduli of 1 Pa, nu = 0
    energy = elastic + energies["mass"] * np.trace(elastic) / np.trace(energies["mass"])
    values, basis = np.linalg.eigh(0.5 * (energy + energy.T))
    kept = values > KEPT**2 * values[-1]
    root = np.sqrt(values[kept])
    touched = np.unique(np.asarray(p.full.space.basis.element_dofs)[:, zone.elements])
    rows = np.flatnonzero(np.isin(p.full.unknowns % p.full.space.size, touched))
    cut = replace(p.full, unknowns=p.full.unknowns[rows])
    return Projector(cut, p.vectors[rows] @ (basis[:, kept] / root)), root[:, None] * basis[:, kept].T


def _energies(p: Projector, space: ShapeSpace, zone: Zone) -> dict[str, Real]:
    """Energies of the plate over the zone, by the keys of `ZONE_DEGREES`, ([4,] powers, q, q)."""
    found: dict[str, list[Real]] = {name: [] for name in ZONE_DEGREES}
    for degrees in _powers():
        for name, energy in _weighed(p, space, zone, degrees).items():
            found[name].append(energy)
    return {name: np.moveaxis(np.array(rows), 0, -3) for name, rows in found.items()}


def _weighed(p: Projector, space: ShapeSpace, zone: Zone, degrees: tuple[int, int]) -> dict[str, Real]:
    """Energies weighed with one power, as in `effect_projection`: those of `ZONE_DEGREES` that reach so high."""
    wanted = {name for name, degree in ZONE_DEGREES.items() if sum(degrees) <= degree}
    found = weighed_energies(p, space, zone.power(degrees, replace(p.full, space=space)), wanted, zone.elements)
    if "mass" in found:
        found["mass"] = found["mass"] + found.pop("rotary")
    return found
