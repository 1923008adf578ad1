"""What plate theory gets wrong in natural frequencies, and those of the shell beside those of a solid.

Bending about the mid-plane stretches one half of the plate and compresses the other. By Poisson's effect points at
height z then move along the normal by const - nu/(1 - nu) (z**2/2) div theta. The deflection w of Reissner's
theory, the one with which the shear force does work, is their mean with the weight of the shear stress,
1 - 4 z**2/h**2; the momentum goes with the plain mean

    w - c h**2 div theta,   c = nu/(1 - nu) (1/12 - 1/20)/2 = nu/(60 (1 - nu)).

The twin takes the momentum of w, so that its frequencies are too low. With shear factor 5/6 those of waves are

    omega**2 = D k**4/(rho h) (1 - (17 - 5 nu)/(60 (1 - nu)) (k h)**2),

those of Rayleigh and Lamb have 7 nu in place of 5 nu: a relative error of -c (k h)**2. That of a mode follows
from its own shape (`mode_errors`). Shear factor 5/(6 - nu) gives the waves of Rayleigh and Lamb, but not the layer
along free edges, whose width (torsion of a strip, 0.630 h, St. Venant) goes with 5/6 (0.632 h).

Constants here are fitted to natural frequencies of solids, see docs/verification.md.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse.linalg import LinearOperator, eigsh

from analysis.arrays import Mask, Real
from analysis.experiment import Patch, Plate
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.shell.assembly import assemble
from simulation.shell.rigidity import U, V
from simulation.shell.shell_model import ShellModel
from simulation.shell.unknowns import factorize

FREE_MODES_SHARE = 0.7
"""Part of the error of waves that the modes of free plates have: 0.65 to 0.74."""
MODES = 0.10
"""Scatter between modes about that, in errors of waves: 0.04 to 0.06, more for the lowest modes."""
CLAMPED, CLAMPED_MODES = 0.02, 0.01
"""Lower by clamped edges, mean and scatter, over h/sqrt(area): the twin holds the rotation of the normal there,
but not the warping of the face."""
STEPS, STEPS_MODES = 0.17, 0.09
"""Higher by abrupt steps of the thickness, mean and scatter, over height times length of the step over the plate's
area: the twin turns the whole height of the thicker part's end face, whose outer parts carry no stress. From a
zone of twice the thickness."""
PATCHES, PATCHES_MODES = 0.14, 0.05
"""Higher by patches, mean and scatter, over their perimeter times the plate's thickness over its area: near the
edge of a patch the solid does not strain as the theory says. From one patch of 0.5 mm on 3 mm of polypropylene."""


@dataclass(frozen=True)
class FrequencyError:
    """Relative errors of natural frequencies by the theory, the twin's over the plate's less 1.

    Attributes
    ----------
    expected : (F,) ndarray
        Mean of the modes near a frequency.
    scatter : (F,) ndarray
        Standard deviation between modes about it.
    """

    expected: Real
    scatter: Real


def wave_error(poisson_ratio: float) -> float:
    """Return c: waves of the theory are too slow by c (k h)**2, relative, to the lowest order."""
    return poisson_ratio / (60.0 * (1.0 - poisson_ratio))


def mode_errors(model: ShellModel, poisson_ratio: float, vectors: Real) -> Real:
    """Relative errors of natural frequencies by the momentum of the mean deflection, to first order.

    Parameters
    ----------
    model : ShellModel
        Of n unknowns.
    vectors : (n, K) ndarray
        Mode shapes.

    Returns
    -------
    (K,) ndarray
        Of the twin: negative for modes of bending.
    """
    shell = model.shell
    weight = shell.density * shell.thickness**3
    mixed = model.unknowns.matrix(shell.cells.bent(weight))
    kinetic = np.einsum("nk,nk->k", vectors, model.mass @ vectors)
    return np.asarray(-wave_error(poisson_ratio) * np.einsum("nk,nk->k", vectors, mixed @ vectors) / kinetic)


def frequency_error(
    plate: Plate,
    youngs_modulus: float,
    poisson_ratio: float,
    frequency: ArrayLike,
    patches: Sequence[Patch] = (),
) -> FrequencyError:
    """Relative errors to be expected of the natural frequencies of a plate's bending.

    Parameters
    ----------
    youngs_modulus : float
        Pa.
    frequency : (F,) array_like, Hz
    """
    h = max([plate.thickness, *(zone.thickness for zone in plate.zone)])
    rigidity = youngs_modulus * h**3 / (12.0 * (1.0 - poisson_ratio**2))
    omega = 2.0 * np.pi * np.asarray(frequency, float)
    of_waves = wave_error(poisson_ratio) * h**2 * omega * np.sqrt(plate.density * h / rigidity)
    held = any(edge.support.kind == "clamped" for edge in plate.supported_edges())
    at_edges = h / plate.area**0.5 if held else 0.0
    at_steps = sum(
        abs(zone.thickness - plate.thickness) * _length(loop.polygon)
        for zone, loop in zip(plate.zone, plate.zone_loops, strict=True)
    )
    at_steps /= plate.area
    at_patches = plate.thickness * sum(_length(patch.loop.polygon) for patch in patches) / plate.area
    parts = (
        (-FREE_MODES_SHARE, MODES, of_waves),
        (-CLAMPED, CLAMPED_MODES, at_edges),
        (STEPS, STEPS_MODES, at_steps),
        (PATCHES, PATCHES_MODES, at_patches),
    )
    expected = np.sum([mean * part + 0.0 * of_waves for mean, _, part in parts], axis=0)
    square = np.sum([(modes * part) ** 2 + 0.0 * of_waves for _, modes, part in parts], axis=0)
    return FrequencyError(np.asarray(expected), np.asarray(np.sqrt(square)))


def _length(polygon: Real) -> float:
    """Perimeter of a closed polygon (K, 2), m."""
    return float(np.linalg.norm(np.roll(polygon, -1, axis=0) - polygon, axis=1).sum())


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
