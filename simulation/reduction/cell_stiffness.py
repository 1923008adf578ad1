"""Stiffness of every cell of a plate on a reduced basis: any field of moduli, constant in a cell, in milliseconds.

A plate's stiffness is the sum over its cells c of C1_c K1_c + C2_c K2_c, as of the whole plate in
`simulation.reduction.reduced_model`. A field that changes within a cell acts, to first order, by its mean there:
what is left out is the product of its change and of that of the strain energy within the cell: on the section-2
panel 0.11 % of the fields at 10 K across, 0.23 % at 20 K.
"""

from collections.abc import Iterable

import numpy as np

from analysis.arrays import Real
from simulation.shell.assembly import stiffness_blocks
from simulation.shell.rigidity import Block
from simulation.shell.shell_model import ShellModel
from simulation.shell.space import ShapeSpace


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
