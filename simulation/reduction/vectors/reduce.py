"""Reduction of a plate over a box of materials and a band: candidates, choice among them, measured error.

Three steps. Rational Krylov spaces at the softest materials give candidate vectors, and the modes computed with
them are corrected at further materials. A proper orthogonal decomposition of responses computed with all
candidates, over the whole box, keeps the leading directions. The full model is solved only to measure the error.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import chain
from typing import Self

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix
from threadpoolctl import threadpool_limits

from analysis.arrays import Real
from analysis.material import MaterialBox
from analysis.progress import Progress
from simulation.reduction.basis_key import BasisTraining
from simulation.reduction.modal_form import columns, few_columns
from simulation.reduction.reduced_model import ReducedModel
from simulation.reduction.vectors.certification import measured_error, mode_corrections
from simulation.reduction.vectors.energy_decomposition import (
    decomposition,
    energy_shift,
    mass_orthonormal,
    middle,
    projected,
    training_loss,
)
from simulation.reduction.vectors.rational_krylov import extended_basis, material_space
from simulation.shell.shell_model import ShellModel

WORKERS = 2
"""Number of materials solved at a time, in threads: sparse factorization releases the interpreter lock."""
SHIFTS_IN_BAND = (0.2, 0.9)
"""Shifts in the band at which a material's stiffness is factorized."""
DAMPED_LINES = 16
"""Number of frequencies per material at which a plate with dashpots is solved."""
STAGE = "reducing the plate"
CORES = 2
"""BLAS threads of large products, which are computed one after the other."""
UNDRIVEN, RIGID = 1e-7, 0.01
"""Share of the strongest coupling of a mode, and of the lowest squared frequency of those with more, below which a
motion counts as rigid and driven by nothing: rounding gives 1e-10, the weakest mode of a patched plate 1e-5."""
FIELD_SHARE = 0.15
"""Share of the truncation error allowed for transfers alone, where the field is certified too."""


def reduce(
    model: ShellModel,
    box: MaterialBox,
    band: tuple[float, float],
    *,
    points: ArrayLike | None = None,
    field_certified: bool = True,
    training: BasisTraining | None = None,
    progress: Progress | None = None,
) -> tuple[ReducedModel, Real]:
    """Reduce `model` for its responses to patches within a box of materials and a band.

    Parameters
    ----------
    band : (float, float)
        Hz.
    points : (K, 2) array_like, optional
        Points at which the deflection is computed, m.
    field_certified : bool
        Whether the deflection there is included in the error, as needed for fields; if not, its accuracy is not
        checked, which is enough to show mode shapes.
    progress : callable, optional
        Called with the stage's name and the share done.

    Returns
    -------
    ReducedModel
        Its `error` is measured against the full model at materials outside the training.
    (n, r) ndarray
        The vectors of its coordinates, orthonormal in the mass.

    Raises
    ------
    ValueError
        For an invalid box or band, or a plate with neither patch nor force.
    RuntimeError
        If the tolerance cannot be reached.
    """
    report = progress or (lambda stage, share: None)
    _check(model, box, band)
    plan = _Plan.of(model, box, band, training or BasisTraining())
    places = np.asarray(() if points is None else points, float).reshape(-1, 2)
    probe = model.deflection(places)
    if field_certified:
        plan = plan.with_field(places, probe)
    vectors, candidate = plan.candidates(report)
    small, vectors = plan.decomposed(vectors, candidate)
    report(STAGE, 0.7)
    small, vectors = plan.certified(small, vectors, report)
    return replace(small, deflection=probe @ vectors, points=places), vectors


@dataclass(frozen=True)
class _Plan:
    """A plate to be reduced, and what every step of it needs.

    Attributes
    ----------
    model : ShellModel
        Of n unknowns.
    box : MaterialBox
    band : (float, float)
        Hz.
    training : BasisTraining
    energy : (n, n) csr_matrix
        Norm of the missing parts.
    dashpots : (n, q) ndarray or None
        See `few_columns`; None for dashpots along an edge, whose columns are fitted to responses.
    responses : (n, S) ndarray
        These responses.
    points, probe : (K, 2) ndarray, m, and (K, n) matrix
        Points at which the deflection is certified, and the deflection there.
    """

    model: ShellModel
    box: MaterialBox
    band: tuple[float, float]
    training: BasisTraining
    energy: csr_matrix
    dashpots: Real | None
    responses: Real
    points: Real
    probe: csr_matrix

    @classmethod
    def of(cls, model: ShellModel, box: MaterialBox, band: tuple[float, float], training: BasisTraining) -> Self:
        energy = csr_matrix(model.stiffness(*middle(box)) + energy_shift(band) * model.mass)
        dashpots = few_columns(model.damping)
        fitted = (
            np.zeros((model.size, 0)) if dashpots is not None else damped_responses(model, box, band, training)
        )
        nowhere = np.zeros((0, 2))
        return cls(model, box, band, training, energy, dashpots, fitted, nowhere, model.deflection(nowhere))

    def with_field(self, points: Real, probe: csr_matrix) -> Self:
        return replace(self, points=points, probe=probe)

    @property
    def lines(self) -> Real:
        """Even grid over the band, Hz."""
        return np.linspace(*self.band, self.training.lines)

    @property
    def tail(self) -> float:
        """Truncation error allowed: its square over the loss factor for transfers; fields are linear in it."""
        share = FIELD_SHARE if len(self.points) else 1.0
        return share * float(np.sqrt(self.training.tolerance * training_loss(self.box)))

    def candidates(self, report: Progress) -> tuple[Real, ReducedModel]:
        """Candidate vectors (n, N), orthonormal in the mass, and the model projected onto them."""
        model, box, band, training = self.model, self.box, self.band, self.training
        vectors = krylov_vectors(
            model, self.dashpots, box, band, self.lines, training, lambda share: report(STAGE, 0.4 * share)
        )
        vectors = np.hstack([vectors, self.responses])
        with threadpool_limits(CORES, user_api="blas"):
            vectors = mass_orthonormal(vectors, self.energy, model.mass)
        candidate = self._projected(vectors)
        for k, materials in enumerate(training.materials(box)[1:]):
            missing = missing_parts(model, vectors, candidate, materials, self.lines, training)
            vectors = self._extended(vectors, missing, candidate)
            candidate = self._projected(vectors, candidate)
            report(STAGE, 0.5 + 0.1 * k)
        return vectors, candidate

    def decomposed(self, vectors: Real, candidate: ReducedModel) -> tuple[ReducedModel, Real]:
        """Return the model on the leading directions of the responses, and their vectors (n, r)."""
        basis = decomposition(candidate, self.lines, 0.25 * self.training.tolerance)
        with threadpool_limits(CORES, user_api="blas"):
            return candidate.restricted(basis), vectors @ basis

    def certified(self, small: ReducedModel, vectors: Real, report: Progress) -> tuple[ReducedModel, Real]:
        """Return the model with its error, and its vectors, extended by what the certification finds missing."""
        plan, tolerance, rounds = self, self.training.tolerance, self.training.rounds
        for attempt in range(rounds):
            measured = measured_error(plan.model, small, vectors, plan.lines, attempt, tolerance)
            if measured.error <= tolerance:
                report(STAGE, 1.0)
                small, vectors = _driven(small, vectors)
                return replace(small, error=measured.error), vectors
            report(STAGE, 0.8 + 0.05 * attempt)
            seen = np.hstack([measured.seen.real, measured.seen.imag])
            plan = replace(plan, responses=np.hstack([plan.responses, seen]))
            seen = seen / np.sqrt(np.einsum("ni,ni->i", seen, plan.energy @ seen))
            vectors = plan._extended(vectors, np.hstack([measured.missing, seen]), small)
            small = plan._projected(vectors, small)
        raise RuntimeError(
            f"the reduced model's error is {measured.error:.2g} after {rounds} rounds; allowed {tolerance:g}"
        )

    def _projected(self, vectors: Real, known: ReducedModel | None = None) -> ReducedModel:
        """Galerkin model on vectors, of the first of which `known` is the projection."""
        dashpots = columns(self.model.damping, self.responses) if self.dashpots is None else self.dashpots
        found = projected(self.model, vectors, self.box, self.band, dashpots, known=known)
        return replace(found, deflection=self.probe @ vectors, points=self.points)

    def _extended(self, vectors: Real, missing: Real, known: ReducedModel) -> Real:
        """Add the leading missing parts to vectors, of which `known` is the projection; see `extended_basis`."""
        gram = known.stiffness(*middle(known.box), 0.0).real + energy_shift(known.band) * np.eye(known.size)
        with threadpool_limits(CORES, user_api="blas"):
            return extended_basis(vectors, missing, self.energy, self.model.mass, self.tail, gram=gram)


def _driven(small: ReducedModel, vectors: Real) -> tuple[ReducedModel, Real]:
    """Return a model and its vectors (n, r) without rigid motions that nothing drives.

    A patch moves a free plate nowhere; rounding brings such a motion in where a basis is extended, and it would be
    listed among the plate's modes, near 0 Hz.
    """
    squares, shapes = np.linalg.eigh(small.stiffness(*middle(small.box), 0.0).real)
    strength = np.abs(np.hstack([small.coupling, small.dashpots]).T @ shapes).max(axis=0)
    driven = strength > UNDRIVEN * strength.max()
    idle = ~driven & (squares < RIGID * squares[driven].min())
    kept = shapes[:, ~idle]
    return (small.restricted(kept), vectors @ kept) if idle.any() else (small, vectors)


def _check(model: ShellModel, box: MaterialBox, band: tuple[float, float]) -> None:
    """ValueError for a plate, box or band that cannot be reduced."""
    if model.coupling.shape[1] == 0:
        raise ValueError("a plate with neither patch nor force has nothing to reduce to")
    most, reached = 1.0 if model.shell.orthotropic else 0.5, box.poisson_ratio[1]
    if not reached < most:
        raise ValueError(f"material box: nu reaches {reached:g}; allowed: below {most:g}")
    if not 0.0 <= band[0] < band[1]:
        raise ValueError(f"band {band[0]:g} to {band[1]:g} Hz must ascend from 0 or above")


def krylov_vectors(
    model: ShellModel,
    dashpots: Real | None,
    box: MaterialBox,
    band: tuple[float, float],
    lines: Real,
    training: BasisTraining,
    report: Callable[[float], None],
) -> Real:
    """Vectors of the Krylov spaces of the softest materials.

    Two shifts each, near the ends of the band: a third factorization costs as much as twenty more vectors.

    Parameters
    ----------
    model : ShellModel
        Of n unknowns.
    dashpots : (n, q) ndarray, optional
        Columns whose forces are loads, as those of the patches are.
    band : (float, float)
        Hz.
    lines : (F,) ndarray, Hz
        Even grid over the band.
    report : callable
        Called with the share done after every material.

    Returns
    -------
    (n, N) ndarray
    """
    shifts = band[0] + np.array(SHIFTS_IN_BAND) * (band[1] - band[0])
    materials = training.materials(box)[0]
    if dashpots is not None and dashpots.size:
        model = replace(model, coupling=np.hstack([model.coupling, dashpots]))

    def space(constants: tuple[float, float]) -> Real:
        return material_space(
            model,
            *constants,
            shifts=shifts,
            lines=lines,
            loss_factor=training_loss(box),
            tolerance=training.tolerance,
        )

    spaces = []
    with ThreadPoolExecutor(WORKERS) as executor:
        for k, found in enumerate(executor.map(space, materials)):
            spaces.append(found)
            report((k + 1) / len(materials))
    return np.hstack(spaces)


def missing_parts(
    model: ShellModel,
    vectors: Real,
    candidate: ReducedModel,
    materials: list[tuple[float, float]],
    lines: Real,
    training: BasisTraining,
) -> Real:
    """Missing parts of the modes at some materials.

    Parameters
    ----------
    model : ShellModel
        Of n unknowns.
    vectors : (n, N) ndarray
        Orthonormal in the mass.
    candidate : ReducedModel
        Projection of `model` onto them.
    materials : list of (float, float)
        E, Pa, and nu.
    lines : (F,) ndarray, Hz
        Even grid over the band.

    Returns
    -------
    (n, s) ndarray
        See `ModeCorrections`.
    """
    loss = training_loss(candidate.box)

    def missing(constants: tuple[float, float]) -> Real:
        return mode_corrections(
            model, vectors, candidate, constants, lines=lines, loss_factor=loss, tolerance=training.tolerance
        ).missing

    with ThreadPoolExecutor(WORKERS) as executor:
        return np.hstack(list(executor.map(missing, materials)))


def damped_responses(
    model: ShellModel, box: MaterialBox, band: tuple[float, float], training: BasisTraining
) -> Real:
    """Real and imaginary parts of responses of a plate with dashpots along an edge over the box.

    Krylov spaces would be too large: every function of the edge would be a load.

    Parameters
    ----------
    model : ShellModel
        Of n unknowns.
    band : (float, float)
        Hz.

    Returns
    -------
    (n, N) ndarray
    """
    lines = np.linspace(*band, DAMPED_LINES)

    def responses(constants: tuple[float, float]) -> Real:
        found = model.responses(*constants, training_loss(box), lines)
        return np.reshape([found.real, found.imag], (2, model.size, -1)).transpose(1, 0, 2).reshape(model.size, -1)

    with ThreadPoolExecutor(WORKERS) as executor:
        return np.hstack(list(executor.map(responses, chain.from_iterable(training.materials(box)))))
