"""Projection of field-weighted energies of a plate and of its patches onto given vectors.

Strains and displacements of the vectors are evaluated at the points of quadrature, some cells at a time; every
energy is then a product of dense matrices.

Strains and displacements of given vectors at points of quadrature, and stiffness of every cell by them.

A plate's stiffness is the sum over its cells c of C1_c K1_c + C2_c K2_c, as of the whole plate in
`simulation.reduction.reduced_model`. A field that changes within a cell acts, to first order, by its mean there:
what is left out is the product of its change and of that of the strain energy within the cell: on the section-2
panel 0.11 % of the fields at 10 K across, 0.23 % at 20 K.
"""

from collections.abc import Callable, Collection, Iterable, Iterator
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Mask, Real, Whole
from analysis.material import Orthotropy
from simulation.reduction.effect_operators import BENDING_DEGREE, MEMBRANE_DEGREE
from simulation.shell.assembly import stiffness_blocks
from simulation.shell.rigidity import FIELDS, SHEAR_FACTOR, STRAINS, THX, Block, CurvedSurface, U, V, W
from simulation.shell.shell_model import ShellModel
from simulation.shell.shell_plate import ShellPlate
from simulation.shell.space import ShapeSpace
from simulation.state.field_basis import polynomial, polynomials
from simulation.state.state_matrices import FullPlate

CELLS_AT_ONCE = 12
"""Cells whose strains are held at a time."""


@dataclass(frozen=True)
class Rows:
    """Strains (8, Q, r) and motions of vectors at points; areas and numbers (Q,) of these.

    Motions are displacements and rotations (5, Q, r), and the director's along x, y and, of a curved plate, z.
    """

    strain: Real
    motion: Real
    director: Real
    dx: Real
    points: Whole


@dataclass(frozen=True)
class Projector:
    """Vectors (n, r) of a plate."""

    full: FullPlate
    vectors: Real

    @cached_property
    def _padded(self) -> Real:
        """Vectors with a row of zeros at the end, (n + 1, r): functions that are no unknowns have number -1."""
        return np.vstack([self.vectors, np.zeros((1, self.vectors.shape[1]))])

    def rows(self, space: ShapeSpace, cells: Mask | None = None) -> Iterator[Rows]:
        """Strains and displacements over all or some cells of a space, `CELLS_AT_ONCE` cells at a time."""
        first, offset = 0, 0
        surface = self.full.shell.surface
        for group in space.groups:
            count, each = group.dx.shape
            chosen = np.arange(count) if cells is None else np.flatnonzero(cells[first : first + count])
            for start in range(0, chosen.size, CELLS_AT_ONCE):
                mine = chosen[start : start + CELLS_AT_ONCE]
                points = (offset + mine[:, None] * each + np.arange(each)).ravel()
                here = {letter: group.factor(letter, mine).transpose(0, 2, 1) for letter in ("0", "x", "y")}
                coordinates = [self._padded[number[group.functions[mine]]] for number in self.full.unknowns.number]
                cache: dict[tuple[int, str], Real] = {}

                def value(field: int, letter: str) -> Real:
                    if (field, letter) not in cache:  # noqa: B023
                        found = here[letter] @ coordinates[field]  # noqa: B023 (called within this iteration)
                        cache[field, letter] = found.reshape(-1, found.shape[-1])  # noqa: B023
                    return cache[field, letter]  # noqa: B023

                motion = np.array([value(field, "0") for field in range(len(FIELDS))])
                director, dx = motion[THX:], group.dx[mine].ravel()
                if surface is None:
                    strain = [sum((value(f, d) for f, d in parts[1:]), value(*parts[0])) for parts in STRAINS]
                else:
                    strain = [
                        np.sum([w[points, None] * value(*part) for part, w in form.items()], axis=0)
                        for form in surface.strains
                    ]
                    up = np.sum(surface.slope[:, points, None] * director, axis=0)
                    director, dx = np.array([*director, up]), dx * surface.area[points]
                yield Rows(np.array(strain), motion, director, dx, points)
            first, offset = first + count, offset + count * each


def cell_stiffness(model: ShellModel, vectors: Real) -> tuple[Real, Real]:
    """Reduce K1 and K2 of every cell.

    Parameters
    ----------
    vectors : (n, r) ndarray
        Over the model's unknowns.

    Returns
    -------
    first, second : (cells, r, r) ndarray
    """
    first, second = stiffness_blocks(model.shell)
    return _reduced(model, first, vectors), _reduced(model, second, vectors)


def cell_centers(space: ShapeSpace) -> Real:
    """Centroid of every cell, (cells, 2), m: there a field that changes evenly in the cell has its mean."""
    centers = [
        np.einsum("cqd,cq->cd", group.places, group.dx) / group.dx.sum(axis=1, keepdims=True)
        for group in space.groups
    ]
    return np.concatenate(centers)


def _reduced(model: ShellModel, blocks: Iterable[Block], vectors: Real) -> Real:
    over, groups = model.unknowns, model.shell.space.groups
    padded = np.vstack([vectors, np.zeros((1, vectors.shape[1]))])  # number -1: no unknown
    found = np.zeros((model.shell.space.mesh.cells, vectors.shape[1], vectors.shape[1]))
    offset = (0, len(model.shell.space.mesh.quads))
    for f, g, group, cells, block in blocks:
        functions, numbers = groups[group].functions[cells], np.arange(len(groups[group].dx))[cells]
        for cell, function, matrix in zip(numbers, functions, block, strict=True):
            part = padded[over.number[f][function]].T @ matrix @ padded[over.number[g][function]]
            found[offset[group] + cell] += part if f == g else part + part.T
    return found


Step = Callable[[], None]
STRAIN_SPACING = 0.004
"""Spacing of the points at which strains are stored, m: some thirty within a spot of 24 mm."""
IN_PLANE = ("bending", "membrane")
SPLIT = (*IN_PLANE, "shear")
"""Energies in parts, each with a modulus of its own: shear of orthotropic sheets in two, else in one."""
"""Energies of in-plane strains, which the moduli Q11, Q22, Q12 and Q66 multiply in the sheet's own axes."""


def weight_table(p: Projector, degrees: Collection[tuple[int, int]]) -> Real:
    """Polynomials at the points of quadrature, (terms, Q)."""
    xi, zeta = p.full.sampling
    return np.array([polynomial(pair, xi, zeta) for pair in degrees])


def plate_energies(
    p: Projector, executor: Executor, step: Step, degrees: tuple[int, int] = (BENDING_DEGREE, MEMBRANE_DEGREE)
) -> dict[str, Real]:
    """Project the energies of the plate, weighted by smooth fields.

    Parameters
    ----------
    executor : Executor
        Works on several energies at a time.
    step : callable
        Called after every chunk of cells.
    degrees : (int, int)
        Largest total degrees of the fields that multiply bending energy, and all others.

    Returns
    -------
    dict of str to ndarray
        Stacks ``bending``, ``membrane``, ``shear``, ``mass``, ``rotary``, ``normal`` and ``momentum`` of
        `EffectOperators`.
    """
    fine, coarse = (len(polynomials(degree)) for degree in degrees)
    table = weight_table(p, polynomials(degrees[0]))
    counts = {"bending": fine, "membrane": coarse, "shear": coarse, "mass": coarse, "normal": 1, "momentum": 1}
    found = weighed_energies(p, p.full.shell.space, table, counts, executor=executor, step=step)
    return {**found, "normal": found["normal"][0], "momentum": found["momentum"][0]}


def weighed_energies(
    p: Projector,
    space: ShapeSpace,
    table: Real,
    counts: dict[str, int],
    *,
    cells: Mask | None = None,
    executor: Executor | None = None,
    step: Step | None = None,
) -> dict[str, Real]:
    """Weighted energies of the plate over some cells; ``mass`` includes ``rotary``.

    Parameters
    ----------
    space : ShapeSpace
        Of the plate, or of the plate with its sensor moved.
    table : (terms, Q) ndarray
        Weights at the points of quadrature; the first is one everywhere and is added to others that are negative
        somewhere, so that every energy is a sum of squares.
    counts : dict
        Number of weights used for each kind: ``bending``, ``membrane``, ``shear``, ``mass``, ``normal`` (the
        square of the deflection), ``momentum`` (minus twice the deflection times the divergence of the rotation;
        no sum of squares, so of the first weight alone).
    cells : (cells,) bool ndarray, optional
        All unless given.
    executor : Executor, optional
        Works on several energies at a time.
    step : callable, optional
        Called after every chunk of cells.

    Returns
    -------
    dict of str to ndarray
        A stack for each kind, its last axes (count, r, r); those of `SPLIT` have one axis more, first.
    """
    r, shell = p.vectors.shape[1], p.full.shell
    scale = _factors(shell)
    run = map if executor is None else executor.map
    counts = {**counts, **({"rotary": counts["mass"]} if "mass" in counts else {})}
    parts = {**dict.fromkeys(IN_PLANE, 4), "shear": 2 if shell.orthotropic else 1}
    found = {name: np.zeros((parts.get(name, 1), count, r, r)) for name, count in counts.items()}
    lift = np.maximum(-table.min(axis=1), 0.0)

    def add(task: tuple[str, int]) -> None:
        name, term = task
        weight = rows.dx * scale[name][rows.points] * (table[term, rows.points] + lift[term])
        if name == "momentum":
            mixed = rows.motion[W].T @ (weight[:, None] * (rows.strain[3] + rows.strain[4]))
            found[name][0, term] -= mixed + mixed.T
            return
        root = np.sqrt(weight)[:, None]
        for place, parts in enumerate(motions[name]):
            for part in parts:
                weighed = root * part
                found[name][place, term] += weighed.T @ weighed  # of one matrix with itself: half of the work

    tasks = [(name, term) for name, count in counts.items() for term in range(count)]
    for rows in p.rows(space, cells):
        motions = _motions(rows, shell)
        list(run(add, tasks))
        if step is not None:
            step()
    return {name: _moduli(name, _lowered(found.pop(name), lift), shell.sheet) for name in tuple(found)}


def _factors(shell: ShellPlate) -> dict[str, Real]:
    """Factor (Q,) of the squared strains or displacements in each energy, at the points of quadrature."""
    h, rho = shell.space.spread(shell.thickness), shell.density
    return {
        "bending": h**3 / 12.0,
        "membrane": h,
        "shear": SHEAR_FACTOR * h,
        "mass": rho * h,
        "rotary": rho * h**3 / 12.0,
        "momentum": rho * h**3,
        "normal": np.ones_like(h) if shell.surface is None else 1.0 / shell.surface.area,
    }


def _motions(rows: Rows, shell: ShellPlate) -> dict[str, list[Any]]:
    """Strains or displacements of which each energy is the sum of squares, in the sheet's own axes.

    One list for each stack of the energy; arrays are (Q, r).
    """
    u, v, w = (rows.motion[field] for field in (U, V, W))
    sheet = shell.sheet
    xz, yz = _across(rows.strain[6:], sheet)
    motions: dict[str, list[Any]] = {
        "shear": [[xz], [yz]] if shell.orthotropic else [[xz, yz]],
        "mass": [[u, v, w]],
        "rotary": [list(rows.director)],
        "normal": [[w]],
    }
    for name, part in zip(IN_PLANE, (rows.strain[3:6], rows.strain[:3]), strict=True):
        x, y, xy = _in_axes(part, sheet.angle)
        motions[name] = [[x], [y], [x + y], [xy]]
    return motions


def _lowered(stack: NDArray[Any], lift: Real) -> NDArray[Any]:
    """Subtract the constants added to weights, term by term in place: stacks take hundreds of megabytes."""
    for term in np.flatnonzero(lift[: stack.shape[1]]):
        stack[:, term] -= lift[term] * stack[:, 0]
    return stack


def _moduli(name: str, squares: NDArray[Any], sheet: Orthotropy) -> Real:
    """Energies of Q11, Q22, Q12 and Q66, in place, from squares of strains x, y, x + y, xy; others kept."""
    if name not in IN_PLANE:
        return np.asarray(squares if name in SPLIT else squares[0])
    x, y = 1.0 - sheet.delta_e, 1.0 + sheet.delta_e
    squares[2] -= squares[0]
    squares[2] -= squares[1]
    for square, factor in zip(squares, (x, y, (x * y) ** 0.5, 1.0 + sheet.delta_g), strict=True):
        square *= factor
    return squares


def _across(strain: Real, sheet: Orthotropy) -> Real:
    """Transverse shear strains (xz, yz) of (2, Q, r) in the sheet's axes, times the roots of its moduli there."""
    if sheet.angle:
        c, s = np.cos(sheet.angle), np.sin(sheet.angle)
        strain = np.array([c * strain[0] + s * strain[1], c * strain[1] - s * strain[0]])
    return strain if sheet.transverse == (1.0, 1.0) else np.sqrt(sheet.transverse)[:, None, None] * strain


def _in_axes(strain: Real, angle: float) -> Real:
    """In-plane strains (x, y, xy) of (3, Q, r) in axes turned by `angle`."""
    if angle == 0.0:
        return strain
    c, s = np.cos(angle), np.sin(angle)
    x, y, xy = strain
    return np.array(
        [
            c * c * x + s * s * y + c * s * xy,
            s * s * x + c * c * y - c * s * xy,
            2.0 * c * s * (y - x) + (c * c - s * s) * xy,
        ]
    )


def strains(p: Projector) -> dict[str, Any]:
    """Entries ``strain``, ``sheet``, ``strain_points``, ``cell`` and ``thickness`` of `EffectOperators`."""
    shell = p.full.shell
    plate, space, over = shell.plate, shell.space, p.full.unknowns
    low, high = np.array(plate.bounds)
    counts = np.ceil((high - low) / STRAIN_SPACING).astype(int)
    x, y = (low[axis] + (np.arange(n) + 0.5) * (high - low)[axis] / n for axis, n in enumerate(counts))
    grid = np.array([(a, b) for a in x for b in y])
    points = grid[plate.contains(grid)]
    by_x, by_y = space.slopes(points)
    matrices = {"x": by_x, "y": by_y, "0": space.values(points)}
    parts: list[list[tuple[int, str, Any]]] = [[(f, d, 1.0) for f, d in row] for row in STRAINS]
    if plate.curvature is not None:
        there = CurvedSurface.of(plate, points)
        root = np.sqrt(there.area)  # strains are squared, and weighed by the area of the drawing
        parts = [[(f, d, (root * w)[:, None]) for (f, d), w in form.items()] for form in there.strains]
    strain = np.array(
        [sum(factor * (over.rows(matrices[d], f) @ p.vectors) for f, d, factor in row) for row in parts]
    )
    sheet = shell.sheet
    in_plane = [_in_axes(part, sheet.angle) for part in (strain[:3], strain[3:6])]
    strain = np.concatenate([*in_plane, _across(strain[6:], sheet)])
    for zone, loop in zip(plate.zone, plate.zone_loops, strict=True):
        # energies are proportional to h and h**3: strains in zones are scaled to the plate's own thickness
        share, here = zone.thickness / plate.thickness, loop.contains(points)
        strain[:, here] *= np.array([share**0.5] * 3 + [share**1.5] * 3 + [share**0.5] * 2)[:, None, None]
    cell = float(np.prod((high - low) / counts))
    return {**unspotted(p), "strain": strain, "strain_points": points, "cell": cell}


def unspotted(p: Projector) -> dict[str, Any]:
    """Return the same entries without a point at which strains are stored: spots are not possible."""
    sheet = p.full.shell.sheet
    return {
        "strain": np.zeros((8, 0, p.vectors.shape[1])),
        "sheet": np.array([1.0 - sheet.delta_e, 1.0 + sheet.delta_e, 1.0 + sheet.delta_g]),
        "strain_points": np.zeros((0, 2)),
        "cell": 1.0,
        "thickness": p.full.shell.plate.thickness,
    }


THICKNESS_STEP = 1e-3
"""Step of central differences by the relative thickness of a patch."""


def patch_energies(p: Projector, executor: Executor, degree: int = BENDING_DEGREE) -> dict[str, Real]:
    """Project the energies of all patches.

    Parameters
    ----------
    executor : Executor
        Works on several patches at a time.
    degree : int
        Largest total degree of the plate's thickness over it.

    Returns
    -------
    dict of str to ndarray
        Stacks ``patch_own``, ``patch_membrane``, ``patch_mass``, ``coupling`` and those of each patch alone of
        `EffectOperators`.
    """
    table, nominal = (
        weight_table(p, polynomials(degree)),
        p.full.shell.space.spread(p.full.shell.thickness),
    )

    def of(place: int) -> tuple[Real, Real, Real, Real]:
        return _one_patch(p, place, table, nominal)

    def thicker(place: int) -> tuple[Real, Real]:
        high, low = (declared_patch(p, place, 1.0 + sign * THICKNESS_STEP) for sign in (1, -1))
        return (high[0] - low[0]) / (2.0 * THICKNESS_STEP), (high[2] - low[2]) / (2.0 * THICKNESS_STEP)

    every = range(len(p.full.shell.patches))
    parts, slopes = list(executor.map(of, every)), list(executor.map(thicker, every))
    r, terms = p.vectors.shape[1], len(table)
    own, membrane, mass, coupling = np.zeros((r, r)), np.zeros((1 + 2 * terms, r, r)), np.zeros((r, r)), []
    for one in parts:
        own, membrane, mass = own + one[0], membrane + one[1], mass + one[2]
        coupling.append(one[3])
    return {
        "patch_own": own + p.vectors.T @ (p.full.supports @ p.vectors),
        "patch_membrane": membrane,
        "patch_mass": mass,
        "patch_alone": np.reshape([one[0] + one[1][0] for one in parts], (len(parts), r, r)),
        "patch_thicker": np.reshape([one[0] for one in slopes], (len(parts), r, r)),
        "patch_mass_alone": np.reshape([one[2] for one in parts], (len(parts), r, r)),
        "thicker_coupling": np.reshape([one[1] for one in slopes], (len(parts), r)),
        "coupling": np.reshape(coupling, (len(parts), 1 + terms, r)).transpose(1, 2, 0),
    }


def declared_patch(p: Projector, place: int, thicker: float = 1.0) -> tuple[Real, Real, Real]:
    """Stiffness, mass and coupling of one patch on the declared plate.

    Parameters
    ----------
    place : int
        Of the patch.
    thicker : float
        Its thickness over the declared one.

    Returns
    -------
    stiffness, mass : (r, r) ndarray
    coupling : (r,) ndarray
    """
    nominal = p.full.shell.space.spread(p.full.shell.thickness)
    own, membrane, mass, coupling = _one_patch(p, place, np.zeros((0, nominal.size)), nominal, thicker)
    return own + membrane[0], mass, coupling[0]


def _one_patch(
    p: Projector, place: int, table: Real, nominal: Real, thicker: float = 1.0
) -> tuple[Real, Real, Real, Real]:
    """Return one patch's terms of `patch_energies`: own, membrane, mass, and its column of the coupling."""
    r, terms, shell = p.vectors.shape[1], len(table), p.full.shell
    patch, covered = shell.patches[place], shell.under[place]
    ceramic, t = shell.materials[patch.material], patch.thickness * thicker
    sign = 1.0 if patch.side == "top" else -1.0
    q11, q12 = ceramic.stiffness
    plane = np.array([[q11, q12, 0.0], [q12, q11, 0.0], [0.0, 0.0, 0.5 * (q11 - q12)]])
    own, mass = np.zeros((r, r)), np.zeros((r, r))
    membrane, coupling = np.zeros((1 + 2 * terms, r, r)), np.zeros((1 + terms, r))
    for rows in p.rows(shell.space, covered):
        dx, h = rows.dx, nominal[rows.points]
        z0, lever = 0.5 * sign * (h + t), 0.5 * sign * h
        bent = rows.strain[3:6]
        flat = rows.strain[:3] + z0[:, None] * bent
        own += t**3 / 12.0 * _form(bent, bent, plane, dx)
        for shear in rows.strain[6:]:
            own += SHEAR_FACTOR * t * plane[2, 2] * shear.T @ (dx[:, None] * shear)
        membrane[0] += t * _form(flat, flat, plane, dx)
        mass += ceramic.density * t * _inertia(rows, z0, t)
        coupling[0] += ceramic.e31 * (flat[0] + flat[1]).T @ dx
        for j in range(terms):
            weight = dx * table[j, rows.points]
            cross = _form(flat, bent, plane, weight * lever)
            membrane[1 + j] += t * (cross + cross.T)
            membrane[1 + terms + j] += t * _form(bent, bent, plane, weight * lever**2)
            coupling[1 + j] += ceramic.e31 * (bent[0] + bent[1]).T @ (weight * lever)
    return own, membrane, mass, coupling


def _form(left: Real, right: Real, plane: Real, weight: Real) -> Real:
    """Energy of two sets of in-plane strains (3, Q, r) for moduli (3, 3) and weights (Q,)."""
    total = np.zeros((left.shape[2], right.shape[2]))
    for a, b in zip(*np.nonzero(plane), strict=True):
        total += plane[a, b] * (left[a].T @ (weight[:, None] * right[b]))
    return total


def _inertia(rows: Rows, height: Real, thickness: float) -> Real:
    """Inertia per area density of a layer whose middle lies `height` (Q,) over the mid-plane."""
    total = np.zeros((rows.motion.shape[2],) * 2)
    for straight, turning in zip((U, V, W), rows.director, strict=False):  # a flat plate's does not move along z
        moving = rows.motion[straight] + height[:, None] * turning
        total += moving.T @ (rows.dx[:, None] * moving)
        total += thickness**2 / 12.0 * turning.T @ (rows.dx[:, None] * turning)
    if len(rows.director) < 3:
        total += rows.motion[W].T @ (rows.dx[:, None] * rows.motion[W])
    return np.asarray(total)
