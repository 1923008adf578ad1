"""Strains and displacements of given vectors at points of quadrature, and stiffness of every cell by them.

A plate's stiffness is the sum over its cells c of C1_c K1_c + C2_c K2_c, as of the whole plate in
`simulation.reduction.reduced_model`. A field that changes within a cell acts, to first order, by its mean there:
what is left out is the product of its change and of that of the strain energy within the cell: on the section-2
panel 0.11 % of the fields at 10 K across, 0.23 % at 20 K.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from analysis.arrays import Mask, Real, Whole
from simulation.shell.assembly import stiffness_blocks
from simulation.shell.rigidity import FIELDS, STRAINS, THX, Block
from simulation.shell.shell_model import ShellModel
from simulation.shell.space import ShapeSpace
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
