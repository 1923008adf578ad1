"""Change of the matrices where a patch is not at its declared place, and slopes under transducers.

A patch has its centre beside its declared place, or is larger. Its own matrices and those of the cells around it
change: they act on the few motions that these cells can make. Where borders move, the mesh moves with them, as in
`simulation.state.patch_departures`. Moves are some tenths of a millimetre. To first order the change of a response
needs the response alone, which the vectors represent; the second order would need vectors that follow the moves,
and without them it is ten times too large: responses are linear in the moves, see `simulation.twin.twin`.

Change of the matrices by an offset of the first sensor patch, as polynomials in reduced coordinates.

The mesh moves with the patch: shear layers at its edges stay on their strips, the patch's own matrices do not
change, and those of the elements around it are smooth functions of the offset.
"""

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_matrix

from analysis.arrays import Mask, Real
from analysis.channel import Footprint
from simulation.reduction.effect_operators import BENDING_DEGREE, OFFSET_DEGREE, ZONE_DEGREES, monomials
from simulation.reduction.effect_projection import Projector, declared_patch, weighed_energies
from simulation.shell.points import footprint_points, footprint_rows
from simulation.shell.rigidity import W
from simulation.state.field_basis import polynomial, polynomials
from simulation.state.state_matrices import FullPlate

MOVE_STEP = 1e-4
"""Step of the central differences by moves, m."""
WEAKEST_BESIDE_PATCH = 3e-5
"""Motions weaker than this share of the strongest are left out: derivatives by moves are good to 1 or 2 %. A
ceramic is so much stiffer than a plastic plate that with 3e-4 those by its sides were wrong by 12 %."""
KINDS = {"bending": 1, "membrane": 1, "shear": 1, "mass": 1}
WAYS = MOVE_STEP * np.eye(4)
"""Moved along x and y, larger along its first side and along its second, m."""


def patch_departures(p: Projector, executor: Executor) -> dict[str, Real]:
    """Entries ``movable``, ``patch_zone`` and those of moves of `EffectOperators`."""
    return _all_patches(p, [_of_patch(p, patch, executor) for patch in range(len(p.full.shell.patches))])


def patches_as_declared(p: Projector) -> dict[str, Real]:
    """Return the same entries, all zero: of patches that are exactly as declared."""
    return _all_patches(p, [_unmoved(0, p.vectors.shape[1])] * len(p.full.shell.patches))


def _all_patches(p: Projector, found: Sequence[dict[str, Real]]) -> dict[str, Real]:
    most = max((len(one["patch_zone"]) for one in found), default=0)
    empty = _unmoved(0, p.vectors.shape[1])
    names = [name for name in empty if name != "movable"]
    stacks = {name: _stacked([one[name] for one in found], empty[name], most) for name in names}
    return {**stacks, "movable": np.array([float(one["movable"]) for one in found])}


def _of_patch(p: Projector, patch: int, executor: Executor) -> dict[str, Real]:
    """Return one patch's entries, over the q motions of the cells around it."""
    try:
        sides = [
            [p.full.moved_by(sign * x, sign * y, patch, (sign * a, sign * b)) for sign in (1, -1)]
            for x, y, a, b in WAYS.tolist()
        ]
        cells = Zone.of(p.full, patch).elements
    except ValueError:  # no room for it, or another patch on the opposite face
        sides, cells = [], p.full.shell.under[patch]
    near, motions = around(p, cells, executor, WEAKEST_BESIDE_PATCH)
    found = _unmoved(len(motions), p.vectors.shape[1])
    found |= {"patch_zone": motions, "movable": np.array(float(bool(sides)))}

    def slopes(two: Sequence[FullPlate]) -> dict[str, Real]:
        ahead, behind = (_energies(near, one, patch, cells) for one in two)
        return {name: (ahead[name] - behind[name]) / (2.0 * MOVE_STEP) for name in ahead}

    for way, slope in enumerate(executor.map(slopes, sides)):
        for name, value in slope.items():
            found[name][way] = value
    return found


def _energies(near: Projector, full: FullPlate, patch: int, cells: Mask) -> dict[str, Real]:
    """Energies of a plate whose patch has moved, over the cells that are deformed, and those of the patch."""
    here, space = Projector(full, near.vectors), full.shell.space
    found = weighed_energies(here, space, np.ones((1, space.dx.size)), KINDS, cells=cells)
    stiffness, mass, coupling = declared_patch(here, patch)
    return {
        "moved_plane": found["bending"][:, 0] + found["membrane"][:, 0],
        "moved_shear": found["shear"].sum(axis=0)[0],
        "moved_mass": found["mass"][0] + found["rotary"][0] + mass,
        "moved_fixed": stiffness,
        "moved_coupling": coupling,
    }


def _unmoved(q: int, r: int) -> dict[str, Real]:
    """Return one patch's entries, all zero."""
    ways = len(WAYS)
    return {
        "patch_zone": np.zeros((q, r)),
        "moved_plane": np.zeros((ways, 4, q, q)),
        **{name: np.zeros((ways, q, q)) for name in ("moved_shear", "moved_mass", "moved_fixed")},
        "moved_coupling": np.zeros((ways, q)),
        "movable": np.zeros(()),
    }


def _stacked(parts: Sequence[Real], empty: Real, most: int) -> Real:
    """Stack the entries of all patches, of as many motions each: those that a patch lacks are zero."""
    shape = tuple(most if size == 0 else size for size in empty.shape)
    found = np.zeros((len(parts), *shape))
    for row, part in zip(found, parts, strict=True):
        row[tuple(slice(size) for size in part.shape)] = part
    return found


def footprint_slopes(full: FullPlate, footprints: Sequence[Footprint], vectors: Real) -> Real:
    """Differentiate the mean deflection over footprints by their shifts and their areas.

    That over a disc of radius a is w + a**2 lap(w) / 8 at its middle, but for a**4: linear in its area. What it is
    more than the deflection of the middle is the derivative by a share of the area, and a share of -1 is a point.

    Parameters
    ----------
    footprints : sequence of S Footprint
    vectors : (n, r) ndarray

    Returns
    -------
    (3, S, r) ndarray
        Along x and y, 1/m, and by the share.
    """
    middles = [replace(one, radius=0.0) for one in footprints]
    more = footprint_rows(full.shell.space, footprints) - footprint_rows(full.shell.space, middles)
    by_area = full.unknowns.rows(csr_matrix(more), W) @ vectors
    return np.concatenate([shift_slopes(full, footprints, vectors), by_area[None]])


def shift_slopes(full: FullPlate, footprints: Sequence[Footprint], vectors: Real) -> Real:
    """Differentiate the mean deflection over footprints by their shifts.

    Parameters
    ----------
    footprints : sequence of S Footprint
    vectors : (n, r) ndarray

    Returns
    -------
    (2, S, r) ndarray
        Along x and y, 1/m.
    """
    points, average = footprint_points(footprints)
    rows = (full.unknowns.rows(csr_matrix(average @ one), W) for one in full.shell.space.slopes(points))
    return np.array([one @ vectors for one in rows]).reshape(2, len(footprints), vectors.shape[1])


OFFSET_RANGE = 0.0025
"""Largest offset of the first sensor patch along x or y, m."""
WEAKEST_MOTION = 2e-6
"""Motions of the elements around the sensor weaker than this share of the strongest are left out."""


@dataclass(frozen=True)
class Zone:
    """The elements that are deformed when the sensor moves.

    Attributes
    ----------
    elements : (elements,) bool ndarray
    middle : (float, float)
        xi and zeta of their centre of area.
    """

    elements: Mask
    middle: tuple[float, float]

    @classmethod
    def of(cls, full: FullPlate, patch: int | None = None) -> "Zone":
        """Find the elements that a small offset of a patch changes, of the first sensor unless it is given."""
        mesh = full.shell.space.mesh
        moved = full.moved_by(1e-3 * OFFSET_RANGE, 1e-3 * OFFSET_RANGE, patch).shell.space.mesh
        shifts = (mesh.points != moved.points).any(axis=1)
        elements = np.concatenate([shifts[mesh.quads].any(axis=1), shifts[mesh.triangles].any(axis=1)])
        area = np.where(full.shell.space.spread(elements), full.shell.space.dx, 0.0)
        xi, zeta = (float(np.average(place, weights=area)) for place in full.sampling)
        return cls(elements, (xi, zeta))

    def powers(self, full: FullPlate) -> Real:
        """Products of powers of xi and zeta about the middle at the points of quadrature, (powers, Q)."""
        xi, zeta = (place - middle for place, middle in zip(full.sampling, self.middle, strict=True))
        return np.array([xi**i * zeta**j for i, j in _powers()])

    def fit(self, full: FullPlate) -> Real:
        """Return ``zone_fit`` of `EffectOperators`."""
        here = full.shell.space.spread(self.elements)
        root = np.sqrt(full.shell.space.dx[here])
        xi, zeta = (place[here] for place in full.sampling)
        powers = self.powers(full)[:, here]
        fields = [polynomial(degrees, xi, zeta) for degrees in polynomials(BENDING_DEGREE)]
        return np.asarray(np.linalg.lstsq((root * powers).T, (root * np.array(fields)).T)[0])


def can_move(full: FullPlate) -> bool:
    """Whether there is space for offsets of the first sensor up to `OFFSET_RANGE`."""
    try:
        for x in (-OFFSET_RANGE, OFFSET_RANGE):
            for y in (-OFFSET_RANGE, OFFSET_RANGE):
                full.moved_by(x, y)
    except ValueError:
        return False
    return True


def offset_energies(p: Projector, executor: Executor) -> dict[str, object]:
    """Stacks ``offset_*`` of `EffectOperators`, fitted over a grid of offsets; zero where it cannot move."""
    if not can_move(p.full):
        return unmoved(p.vectors.shape[1])
    zone = Zone.of(p.full)
    near, motions = around(p, zone.elements, executor)
    origin = _zone_energies(near, p.full, zone)
    places = padua_points(OFFSET_DEGREE)
    changes = {
        name: np.empty((*start.shape[:-2], len(places), *start.shape[-2:])) for name, start in origin.items()
    }

    def move(k: int) -> None:
        x, y = places[k]
        energies = _zone_energies(near, p.full.moved_by(OFFSET_RANGE * x, OFFSET_RANGE * y), zone)
        for name, start in origin.items():
            changes[name][..., k, :, :] = energies[name] - start

    list(executor.map(move, range(len(places))))
    fit = np.linalg.pinv(np.array([monomials(x, y) for x, y in places]))
    stacks = {f"offset_{name}": _fitted(fit, changes.pop(name)) for name in origin}
    return {"zone": motions, "zone_fit": zone.fit(p.full), "offset_range": OFFSET_RANGE, **stacks}


def _fitted(fit: Real, samples: Real) -> Real:
    """Coefficients (..., m, q, q) of samples (..., k, q, q), in their memory: both at once would be the peak."""
    for place in np.ndindex(samples.shape[:-3]):
        one = samples[place]
        one[: len(fit)] = np.tensordot(fit, one, axes=1)
    return samples[..., : len(fit), :, :]


def padua_points(degree: int) -> list[tuple[float, float]]:
    """Points of a square that determine polynomials of a total degree (Caliari et al., AMC 165, 2005)."""
    x = np.cos(np.pi * np.arange(degree + 1) / degree)
    y = np.cos(np.pi * np.arange(degree + 2) / (degree + 1))
    return [(float(x[i]), float(y[j])) for i in range(x.size) for j in range(y.size) if (i + j) % 2 == 0]


def _powers() -> list[tuple[int, int]]:
    return polynomials(max(ZONE_DEGREES.values()))


def unmoved(size: int) -> dict[str, object]:
    """Return the stacks, all zero, of a sensor that cannot move."""
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


def around(p: Projector, cells: Mask, executor: Executor, least: float = WEAKEST_MOTION) -> tuple[Projector, Real]:
    """Find the leading motions of some cells.

    Parameters
    ----------
    cells : (cells,) bool ndarray
    executor : Executor
        Works on several energies at a time.
    least : float
        Motions weaker than this share of the strongest are left out.

    Returns
    -------
    near : Projector
        With their vectors, (n, q).
    motions : (q, r) ndarray
        The reduced coordinates' shares in them.
    """
    ones = np.ones((1, p.full.shell.space.dx.size))
    counts = dict.fromkeys(ZONE_DEGREES, 1)
    found = weighed_energies(p, p.full.shell.space, ones, counts, cells=cells, executor=executor)
    in_plane = found["bending"][:, 0] + found["membrane"][:, 0]
    elastic = (
        in_plane[0] + in_plane[1] + 0.5 * in_plane[3] + found["shear"].sum(axis=0)[0]
    )  # moduli of 1 Pa, nu = 0
    inertia = found["mass"][0] + found["rotary"][0]
    energy = elastic + inertia * np.trace(elastic) / np.trace(inertia)
    values, basis = np.linalg.eigh(0.5 * (energy + energy.T))
    kept = values > least**2 * values[-1]
    root = np.sqrt(values[kept])
    return Projector(p.full, p.vectors @ (basis[:, kept] / root)), root[:, None] * basis[:, kept].T


def _zone_energies(p: Projector, full: FullPlate, zone: Zone) -> dict[str, Real]:
    """Energies over the zone of a plate, by the keys of `ZONE_DEGREES`, ([4,] powers, q, q)."""
    counts = {name: len(polynomials(degree)) for name, degree in ZONE_DEGREES.items()}
    here = Projector(full, p.vectors)
    found = weighed_energies(here, full.shell.space, zone.powers(full), counts, cells=zone.elements)
    found["mass"] = found["mass"] + found.pop("rotary")
    found["shear"] = found["shear"].sum(axis=0)
    return found
