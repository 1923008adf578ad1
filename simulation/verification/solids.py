"""Natural frequencies of the twin's shell beside those of the same plate as a solid."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from scipy.sparse.linalg import LinearOperator, eigsh

from analysis.arrays import Mask, Real
from analysis.experiment import Patch, Plate
from simulation.meshing.recipe import MeshRecipe
from simulation.shell.assembly import assemble
from simulation.shell.rigidity import U, V
from simulation.shell.shell_model import ShellModel
from simulation.shell.theory_error import mode_errors
from simulation.shell.unknowns import factorize

MESH = MeshRecipe(spacing=0.05, levels=2, outer_corners=True)
DEGREE = 6
"""With this mesh frequencies are converged to some 1e-6."""
SHIFT = -((2 * np.pi * 5.0) ** 2)
"""Negative, so that a free plate's matrix is not singular, rad2/s2."""


@dataclass(frozen=True)
class SolidComparison:
    """Elastic modes of one plate that are not modes in its plane.

    Attributes
    ----------
    plate : Plate
    patches : tuple of Patch
    material : (float, float)
        E [Pa] and nu.
    solid : (K,) ndarray
        Natural frequencies of the solid, Hz, ascending.
    error : (K,) ndarray
        Of the twin, relative to these.
    predicted : (K,) ndarray
        What `mode_errors` says of it.
    """

    plate: Plate
    patches: tuple[Patch, ...]
    material: tuple[float, float]
    solid: Real
    error: Real
    predicted: Real

    @classmethod
    def of(cls, stored: Mapping[str, Any]) -> Self:
        """Compute the twin of a case of docs/make_solid_references.py."""
        plate = Plate.model_validate(stored["plate"])
        patches = tuple(Patch.model_validate(one) for one in stored["patches"])
        material = (stored["youngs_modulus"], stored["poisson_ratio"])
        model = assemble(plate, patches, recipe=MESH, degree=DEGREE)
        solid, rigid = np.array(stored["frequency"]), 0 if plate.support else 6
        squares, vectors = _modes(model, material, rigid + solid.size)
        squares, vectors = squares[rigid:], vectors[:, rigid:]
        bending = _bending(model, vectors)
        error = np.sqrt(squares) / (2 * np.pi) / solid - 1.0
        predicted = mode_errors(model, material[1], vectors)
        return cls(plate, patches, material, solid[bending], error[bending], predicted[bending])

    @property
    def left(self) -> Real:
        """Error of the twin after the prediction, (K,)."""
        return self.error - self.predicted


def _modes(model: ShellModel, material: tuple[float, float], count: int) -> tuple[Real, Real]:
    """Lowest eigenvalues, rad2/s2, ascending, and vectors (n, count)."""
    stiffness = model.stiffness(*material)
    solve = factorize(stiffness - SHIFT * model.mass).solve
    squares, vectors = eigsh(
        stiffness,
        count,
        model.mass,
        sigma=SHIFT,
        OPinv=LinearOperator(stiffness.shape, matvec=solve, dtype=float),
        v0=np.random.default_rng(0).standard_normal(model.size),
    )
    order = np.argsort(squares)
    return squares[order], vectors[:, order]


def _bending(model: ShellModel, vectors: Real) -> Mask:
    """Which modes (K,) move less in the plane than across it."""
    in_plane = np.isin(model.unknowns.chosen // model.space.size, (U, V))
    moving = np.where(in_plane[:, None], vectors, 0.0)
    total = np.einsum("nk,nk->k", vectors, model.mass @ vectors)
    return np.asarray(np.einsum("nk,nk->k", moving, model.mass @ moving) < 0.5 * total)
