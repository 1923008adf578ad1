"""Assembly of a declared plate's matrices, whole or with what its responses need; static condensation.

A few responses of the plate are computed with functions of high degree everywhere; a function is kept if its share
of the energy of some response exceeds a tolerance. The energy dropped is an estimate of the error. Interior
functions are eliminated cell by cell, so that only functions of edges and points enter the sparse solver.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import count

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix

from analysis.arrays import Mask, Real, Whole
from analysis.channel import Footprint
from analysis.experiment import Patch, Plate
from analysis.material import MaterialBox
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.shell.edges import LineBlock
from simulation.shell.fineness import Fineness
from simulation.shell.piezo_material import PIEZO_MATERIALS, PiezoMaterial
from simulation.shell.points import footprint_rows, spring_discs
from simulation.shell.rigidity import THX, THY, Block, U, V, W, moduli, plane_stress_moduli, transverse
from simulation.shell.shell_model import ShellModel
from simulation.shell.shell_plate import ShellPlate, couplings
from simulation.shell.space import ShapeSpace
from simulation.shell.unknowns import Unknowns, elimination_order, factorize

CELLS_AT_ONCE = 16
"""Number of cells condensed at a time."""
Fields = tuple[int, ...]


@dataclass(frozen=True)
class ResponseProblem:
    """One dynamic stiffness Z = K - w**2 M, with its loads.

    Attributes
    ----------
    terms : sequence of (float, list of Block)
        Matrices, and their factors in Z.
    lines : list of LineBlock
        Springs along edges.
    loads : (5, N, L) ndarray
    energy : (5, N) ndarray
        Diagonal of K + w**2 M.
    """

    terms: Sequence[tuple[float, Sequence[Block]]]
    lines: list[LineBlock]
    loads: Real
    energy: Real


@dataclass(frozen=True)
class Condensed:
    """Condensation of the interior functions of some cells of one group.

    Attributes
    ----------
    inner : (C, i) ndarray of int
        Field and function, as in `Unknowns.chosen`, of the eliminated unknowns.
    outer : (C, e) ndarray of int
        Remaining unknowns, -1 where they are held at zero.
    schur : (C, e, e) ndarray
        Condensed stiffness of these.
    followed : (C, i, e) ndarray
        Minus the inner response per outer displacement.
    alone : (C, i, L) ndarray
        Inner response to the loads with the outer unknowns held.
    lost : (C, e, L) ndarray
        Reduction of the outer loads by the inner ones.
    """

    inner: Whole
    outer: Whole
    schur: Real
    followed: Real
    alone: Real
    lost: Real


Parts = tuple[list[Block], list[Block], list[Block], list[Block]]
"""Blocks of K1, K2, Kp and M."""
WORKERS = 2  # matrices, or responses, at a time
SELECTING_FORCES = 12
"""Number of forces whose responses select functions: the field of any other is as smooth as theirs."""
MESHED, INTEGRATED, CHOSEN = 0.1, 0.25, 0.95
"""Shares of the work done after meshing, integration and selection of functions."""


def assemble(
    plate: Plate,
    patches: Sequence[Patch] = (),
    *,
    recipe: MeshRecipe | None = None,
    degree: int = 6,
    materials: Mapping[str, PiezoMaterial] = PIEZO_MATERIALS,
) -> ShellModel:
    """Matrices of a plate with patches, with all functions of one degree.

    Parameters
    ----------
    patches : sequence of Patch
        Voltages and charges keep this order.
    materials : mapping
        Piezo material of each ``Patch.material``.

    Raises
    ------
    GeometryError
        Where no good mesh is found.
    """
    shell = ShellPlate.of(plate, patches, recipe=recipe, degree=degree, materials=materials)
    return assembled(shell, ~shell.held, _parts(shell))


ENERGY_RATIO_ABOVE = 0.03
"""Energy of functions above the highest degree, over that in the highest degree: determined with finer meshes at
degree 7, where it equals the energy of the functions left out. On too coarse a mesh the latter is large."""


@dataclass(frozen=True)
class Choice:
    """Functions kept, and how much was dropped.

    Attributes
    ----------
    kept : (5, N) ndarray of bool
    dropped : float
        Largest share of a response's energy in the dropped functions and, by estimate, in functions of still
        higher degree: `ENERGY_RATIO_ABOVE` times that of the highest degree.
    """

    kept: Mask
    dropped: float


def chosen(
    space: ShapeSpace,
    held: Mask,
    problems: Sequence[ResponseProblem],
    tolerance: float,
    executor: Executor | None = None,
    step: Callable[[], None] | None = None,
    counted: int | None = None,
) -> Choice:
    """Keep the functions whose share |x|**2 K_ii / (x' K x) of some response x exceeds `tolerance`.

    Functions of points are always kept.

    Parameters
    ----------
    space : ShapeSpace
        Of N functions.
    held : (5, N) ndarray of bool
        Functions held at zero by supports.
    executor : Executor, optional
        Solves several problems at a time.
    step : callable, optional
        Called after each problem.
    counted : int, optional
        Number of loads, the first ones, in whose responses the dropped energy is counted; default: all.
    """
    order = elimination_order(space)
    run = map if executor is None else executor.map
    shares = []
    for found in run(lambda problem: _shares(space, held, problem, order), problems):
        shares.append(found)
        if step is not None:
            step()
    worst = np.max([share.max(axis=2) for share in shares], axis=0)
    kept = worst > tolerance
    kept[:, : len(space.mesh.points)] = True
    kept &= ~held
    highest = _highest(space)
    lost = [share[~kept].sum(axis=0) + ENERGY_RATIO_ABOVE * share[:, highest].sum(axis=(0, 1)) for share in shares]
    dropped = max(float(one[:counted].max(initial=0.0)) for one in lost)
    return Choice(kept, dropped)


def _highest(space: ShapeSpace) -> Mask:
    """Return which functions (N,) of edges and of the interiors of cells have the highest degree."""
    p, found = space.degree, np.zeros(space.size, bool)
    inside = np.arange((p - 1) ** 2)
    along = np.stack([inside // (p - 1), inside % (p - 1)])
    last = {4: (along == p - 2).any(axis=0), 3: np.arange((p - 1) * (p - 2) // 2) >= (p - 2) * (p - 3) // 2}
    for corners, group in zip((4, 3), space.groups, strict=True):
        edges = np.tile(np.arange(p - 1) == p - 2, corners)
        local = np.concatenate([np.zeros(corners, bool), edges, last[corners]])
        found[group.functions[:, local]] = True
    return found


def diagonal(space: ShapeSpace, blocks: Iterable[Block]) -> Real:
    """Diagonal of a matrix given by its blocks, (5, N)."""
    found = np.zeros((5, space.size))
    for f, g, group, cells, block in blocks:
        if f == g:
            np.add.at(found[f], space.groups[group].functions[cells], np.einsum("cii->ci", block))
    return found


def _shares(space: ShapeSpace, held: Mask, problem: ResponseProblem, order: Whole) -> Real:
    """Share of every function in the energy of every response, (5, N, L)."""
    size = space.size
    free = ~held
    free[:, first_inside(space) :] = False
    outer = Unknowns.ordered(space, free, order)
    loads = problem.loads.reshape(5 * size, -1)
    matrix, load, parts = without_insides(space, problem, outer)
    solved = factorize(matrix).solve(load)
    answer = np.zeros_like(loads)
    answer[outer.chosen] = solved
    padded = np.vstack([solved, np.zeros((1, load.shape[1]))])  # number -1: held at zero
    for part in parts:
        answer[part.inner] = part.alone - part.followed @ padded[part.outer]
    energy = problem.energy.reshape(-1, 1) * answer**2
    total = np.maximum(np.abs(np.einsum("nl,nl->l", loads, answer)), energy.max(axis=0))  # x' Z x is x' load
    return np.asarray((energy / total).reshape(5, size, -1))


def assemble_for(
    plate: Plate,
    patches: Sequence[Patch],
    box: MaterialBox,
    band: tuple[float, float],
    *,
    footprints: Sequence[Footprint] = (),
    attached: Sequence[Footprint] = (),
    fineness: Fineness | None = None,
    progress: Callable[[float], None] | None = None,
) -> ShellModel:
    """Matrices of a plate with the functions that its responses to patches and point forces need.

    Parameters
    ----------
    patches : sequence of Patch
        Voltages and charges keep this order.
    box : MaterialBox
        Ranges of the materials: responses of the softest and of a middle one select functions.
    band : (float, float)
        Hz.
    footprints : sequence of Footprint
        Discs of forces whose responses are used in the selection, as those of springs and dashpots at points are;
        `SELECTING_FORCES` are enough.
    attached : sequence of Footprint, optional
        Discs on which effects act: used in the selection, not counted in the energy dropped.
    progress : callable, optional
        Called with the share done, 0 to 1.

    Raises
    ------
    GeometryError
        Where no good mesh is found.
    """
    report = progress or (lambda share: None)
    report(0.0)
    fine = fineness or Fineness()
    shell = ShellPlate.of(plate, patches, recipe=fine.recipe(plate, box, band), degree=fine.degree)
    report(MESHED)
    parts = _parts(shell)
    report(INTEGRATED)
    if not fine.tolerance:
        return assembled(shell, ~shell.held, parts)
    (e0, e1), (n0, n1) = box.youngs_modulus, box.poisson_ratio
    # a third response changes 1 function in 100, and takes as long as these two, which are solved in parallel
    constants = [(e0, n1, band[1]), (float(np.sqrt(e0 * e1)), n0, 0.75 * sum(band))]
    loads = _loads(shell, [*footprints, *spring_discs(plate), *attached])
    problems = _problems(shell, parts, loads, constants)
    solved = count(1)

    def step() -> None:
        report(INTEGRATED + (CHOSEN - INTEGRATED) * next(solved) / len(problems))

    with ThreadPoolExecutor(WORKERS) as executor:
        counted = loads.shape[-1] - len(attached)
        choice = chosen(shell.space, shell.held, problems, fine.share(box), executor, step, counted)
    model = assembled(shell, choice.kept, parts, choice.dropped)
    report(1.0)
    return model


def assemble_chosen(
    plate: Plate,
    patches: Sequence[Patch],
    box: MaterialBox,
    band: tuple[float, float],
    kept: Mask,
    *,
    fineness: Fineness | None = None,
) -> ShellModel | None:
    """Assemble a plate with functions that `assemble_for` has chosen.

    Parameters
    ----------
    band : (float, float)
        Hz.
    kept : (5, N) ndarray of bool
        By field and function.

    Returns
    -------
    ShellModel or None
        None if the functions are those of another mesh.

    Raises
    ------
    GeometryError
        Where no good mesh is found.
    """
    fine = fineness or Fineness()
    shell = ShellPlate.of(plate, patches, recipe=fine.recipe(plate, box, band), degree=fine.degree)
    if kept.shape != shell.held.shape:
        return None
    return assembled(shell, kept, _parts(shell))


def assembled(shell: ShellPlate, kept: Mask, parts: Parts, dropped: float = 0.0) -> ShellModel:
    """Sparse matrices over the selected functions.

    Parameters
    ----------
    kept : (5, N) ndarray of bool
        By field and function.
    parts : tuple of lists of blocks
        Of K1, K2, Kp and M.
    dropped : float
        Estimate of the energy lost, see `Choice`.
    """
    unknowns = Unknowns.of(shell.space, kept)
    with ThreadPoolExecutor(WORKERS) as executor:
        first, second, patches, mass = executor.map(unknowns.matrix, parts)
    patches = csr_matrix(patches + unknowns.springs(shell))
    columns = [unknowns.vector(coupling) for coupling in couplings(shell, shell.thickness)]
    return ShellModel(
        shell=shell,
        unknowns=unknowns,
        stiffness_1=first,
        stiffness_2=second,
        stiffness_patch=patches,
        mass=mass,
        damping=unknowns.springs(shell, damping=True),
        coupling=np.array(columns).reshape(len(columns), unknowns.size).T,
        capacitance=shell.capacitance,
        dropped=dropped,
    )


def _loads(shell: ShellPlate, footprints: Sequence[Footprint]) -> Real:
    """Force per volt of the patches, then unit forces on the footprints, by field and function (5, N, L)."""
    patches = couplings(shell, shell.thickness)
    loads = np.zeros((5, shell.space.size, len(patches)))
    for k, coupling in enumerate(patches):
        for field, values in coupling.items():
            loads[field, :, k] = values
    forces = np.zeros((5, shell.space.size, len(footprints)))
    if footprints:
        forces[W] = footprint_rows(shell.space, footprints).toarray().T
    return np.concatenate([loads, forces], axis=2)


def _problems(
    shell: ShellPlate, parts: Parts, loads: Real, constants: Sequence[tuple[float, float, float]]
) -> list[ResponseProblem]:
    """Undamped responses to the loads (5, N, L) at each E [Pa], nu and frequency [Hz]."""
    springs = list(shell.springs())
    diagonals = [diagonal(shell.space, blocks) for blocks in parts]
    problems = []
    for youngs_modulus, poisson_ratio, frequency in constants:
        c1, c2 = plane_stress_moduli(youngs_modulus, poisson_ratio)
        omega2 = (2 * np.pi * frequency) ** 2
        factors = (c1, c2, 1.0, omega2)
        energy = sum((factor * one for factor, one in zip(factors, diagonals, strict=True)), np.zeros(()))
        terms = list(zip((c1, c2, 1.0, -omega2), parts, strict=True))
        problems.append(ResponseProblem(terms, springs, loads, np.asarray(energy)))
    return problems


def stiffness_blocks(shell: ShellPlate) -> tuple[list[Block], list[Block]]:
    """Cells' matrices of K1 and of K2, by which the plate is as stiff as C1 K1 + C2 K2."""
    thickness, sheet = shell.thickness, shell.sheet
    first = shell.plate_stiffness(moduli(sheet, 1.0, 0.0), transverse(sheet, 0.5), thickness)
    second = shell.plate_stiffness(moduli(sheet, 0.0, 1.0), transverse(sheet, -0.5), thickness)
    return list(shell.cells.of(first)), list(shell.cells.of(second))


def _parts(shell: ShellPlate) -> Parts:
    patches = list(shell.cells.of(shell.patch_stiffness(shell.thickness)))
    return *stiffness_blocks(shell), patches, list(shell.inertia(shell.thickness))


def without_insides(
    space: ShapeSpace, problem: ResponseProblem, outer: Unknowns
) -> tuple[csr_matrix, Real, list[Condensed]]:
    """Z and loads over the outer unknowns, and the data to recover the inner ones.

    A separate function, so that the triplets of Z, the largest arrays, are freed before it is factorized.

    Parameters
    ----------
    outer : Unknowns
        The m unknowns shared by cells.

    Returns
    -------
    matrix : (m, m) csr_matrix
    load : (m, L) ndarray
    parts : list of Condensed
        With empty `schur` and `lost`, which are contained in matrix and load.
    """
    load = problem.loads.reshape(5 * space.size, -1)[outer.chosen].copy()
    rows, columns, values, parts = [], [], [], []
    for part in _condensed(space, problem, outer.number):
        used = part.outer >= 0
        np.subtract.at(load, part.outer[used], part.lost[used])
        cell, r, c = np.nonzero(used[:, :, None] & used[:, None, :])
        rows.append(part.outer[cell, r].astype(np.int32))
        columns.append(part.outer[cell, c].astype(np.int32))
        values.append(part.schur[cell, r, c])
        parts.append(replace(part, schur=np.zeros(0), lost=np.zeros(0)))
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    del values, rows, columns
    matrix = csr_matrix(coo_matrix(entries, shape=(outer.size, outer.size)))
    if problem.lines:
        matrix = csr_matrix(matrix + outer.lines(problem.lines))
    return matrix, load, parts


def _condensed(space: ShapeSpace, problem: ResponseProblem, number: Whole) -> Iterator[Condensed]:
    """Condense all cells, `CELLS_AT_ONCE` at a time; `number` (5, N) is that of `Unknowns`."""
    size, first = space.size, first_inside(space)
    loads = problem.loads.reshape(5 * size, -1)
    for group in (0, 1):
        functions = space.groups[group].functions
        count = functions.shape[1]
        for fields, cells in _coupled(problem, group, len(functions)):
            for start in range(0, cells.size, CELLS_AT_ONCE):
                mine = cells[start : start + CELLS_AT_ONCE]
                here = functions[mine]
                inside = np.flatnonzero(here[0] >= first)
                i = (np.arange(len(fields))[:, None] * count + inside).ravel()
                e = np.setdiff1d(np.arange(len(fields) * count), i)
                place = (np.array(fields)[:, None] * size + here[:, None, :]).reshape(len(here), -1)
                z = _dense(problem, group, mine, fields, count)
                between = z[:, i[:, None], e]
                right = np.concatenate([between, loads[place[:, i]]], axis=2)
                followed = np.linalg.solve(z[:, i[:, None], i], right)
                followed, alone = followed[:, :, : e.size], followed[:, :, e.size :]
                across = between.transpose(0, 2, 1)
                yield Condensed(
                    inner=place[:, i],
                    outer=number.ravel()[place[:, e]],
                    schur=z[:, e[:, None], e] - across @ followed,
                    followed=followed,
                    alone=alone,
                    lost=across @ alone,
                )


def _coupled(problem: ResponseProblem, group: int, count: int) -> list[tuple[Fields, Whole]]:
    """Coupled fields, and the cells of a group with this coupling: all fields under patches and on curved plates.

    Elsewhere membrane and bending are uncoupled, and zeros between them would only fill the factors.
    """
    found = np.zeros(count, bool)
    for _, blocks in problem.terms:
        for f, g, which, cells, block in blocks:
            if which == group and f <= V < g:
                found[cells] |= block.any(axis=(1, 2))
    together, apart = np.flatnonzero(found), np.flatnonzero(~found)
    return [((U, V, W, THX, THY), together), ((U, V), apart), ((W, THX, THY), apart)]


def first_inside(space: ShapeSpace) -> int:
    """Return the number of the first function inside a cell."""
    return len(space.mesh.points) + len(space.mesh.edges) * (space.degree - 1)


def _dense(problem: ResponseProblem, group: int, cells: Whole, fields: Fields, count: int) -> Real:
    """Z of some fields on some cells of a group as whole matrices, (C, f N, f N)."""
    z = np.zeros((len(cells), len(fields) * count, len(fields) * count))
    part = {field: slice(k * count, (k + 1) * count) for k, field in enumerate(fields)}
    for factor, blocks in problem.terms:
        for f, g, which, acting, block in blocks:
            if which != group or f not in part or g not in part:
                continue
            there = np.searchsorted(acting, cells)
            same = acting[np.minimum(there, len(acting) - 1)] == cells
            if not same.any():
                continue
            here = slice(None) if same.all() else np.flatnonzero(same)
            some = factor * block[there[same]]
            z[here, part[f], part[g]] += some
            if f != g:
                z[here, part[g], part[f]] += some.transpose(0, 2, 1)
    return z
