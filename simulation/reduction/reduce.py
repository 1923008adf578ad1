"""Reduction of a plate over a box of materials and a band, with a measured error.

Three steps. Rational Krylov spaces at the softest materials give candidate vectors, and the modes computed with
them are corrected at further materials. A proper orthogonal decomposition of responses computed with all
candidates, over the whole box, keeps the leading directions. The full model is solved only to measure the error.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import chain

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix
from threadpoolctl import threadpool_limits

from analysis.arrays import Real
from analysis.material import MaterialBox
from analysis.progress import Progress
from simulation.reduction.basis_training import BasisTraining
from simulation.reduction.certification import measured_error
from simulation.reduction.dashpots import columns, few_columns
from simulation.reduction.energy_decomposition import (
    decomposition,
    energy_shift,
    mass_orthonormal,
    middle,
    training_loss,
)
from simulation.reduction.galerkin import projected
from simulation.reduction.missing_responses import extended_basis
from simulation.reduction.mode_corrections import mode_corrections
from simulation.reduction.rational_krylov import material_space
from simulation.reduction.reduced_model import ReducedModel
from simulation.shell.shell_model import ShellModel

STAGE = "reducing the plate"
WORKERS = 2
"""Number of materials solved at a time, in threads: sparse factorization releases the interpreter lock."""
SHIFTS = (0.2, 0.9)
"""Shifts in the band at which a material's stiffness is factorized."""
FIELD_SHARE = 0.15
"""Share of the truncation error allowed for transfers alone, where the field is certified too."""
DAMPED_LINES = 16
"""Number of frequencies per material at which a plate with dashpots is solved."""


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
    model : ShellModel
    box : MaterialBox
    band : (float, float)
        Hz.
    points : (K, 2) array_like, optional
        Points at which the deflection is computed, m.
    field_certified : bool
        Whether the deflection there is included in the error, as needed for fields; if not, its accuracy is not
        checked, which is enough to show mode shapes.
    training : BasisTraining, optional
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
    training = training or BasisTraining()
    report = progress or (lambda stage, share: None)
    _check(model, box, band)
    lines = np.linspace(*band, training.lines)
    places = np.asarray(() if points is None else points, float).reshape(-1, 2)
    probe = model.deflection(places)
    counted = slice(None) if field_certified else slice(0)
    # transfers: the square of the truncation error over the loss factor; fields are linear in it
    share = FIELD_SHARE if len(places[counted]) else 1.0
    tail = share * float(np.sqrt(training.tolerance * training_loss(box)))
    dashpots = few_columns(model.damping)
    responses = _damped_responses(model, box, band, training) if dashpots is None else np.zeros((model.size, 0))
    energy = model.stiffness(*middle(box)) + energy_shift(band) * model.mass
    vectors = np.hstack([_candidates(model, dashpots, box, band, lines, training, report), responses])
    with threadpool_limits(WORKERS, user_api="blas"):  # large products, one after the other
        vectors = mass_orthonormal(vectors, energy, model.mass)

    def on(basis: Real, responses: Real, known: ReducedModel | None = None) -> ReducedModel:
        damping = columns(model.damping, responses) if dashpots is None else dashpots
        found = projected(model, basis, box, band, damping, known=known)
        return replace(found, deflection=probe[counted] @ basis, points=places[counted])

    larger = on(vectors, responses)
    for k, materials in enumerate(training.materials(box)[1:]):
        missing = _corrections(model, vectors, larger, materials, lines, training)
        vectors = _extended(vectors, missing, larger, energy, model.mass, tail)
        larger = on(vectors, responses, larger)
        report(STAGE, 0.5 + 0.1 * k)
    basis = decomposition(larger, lines, 0.25 * training.tolerance)
    with threadpool_limits(WORKERS, user_api="blas"):
        small, vectors = larger.restricted(basis), vectors @ basis
    report(STAGE, 0.7)
    for attempt in range(training.rounds):
        measured = measured_error(model, small, vectors, lines, attempt, training.tolerance)
        if measured.error <= training.tolerance:
            report(STAGE, 1.0)
            return replace(small, error=measured.error, deflection=probe @ vectors, points=places), vectors
        report(STAGE, 0.8 + 0.05 * attempt)
        seen = np.hstack([measured.seen.real, measured.seen.imag])
        responses = np.hstack([responses, seen])
        seen = seen / np.sqrt(np.einsum("ni,ni->i", seen, energy @ seen))
        missing = np.hstack([measured.missing, seen])
        vectors = _extended(vectors, missing, small, energy, model.mass, tail)
        small = on(vectors, responses, small)
    raise RuntimeError(
        f"the reduced model's error is {measured.error:.2g} after {training.rounds} rounds; "
        f"allowed {training.tolerance:g}"
    )


def _check(model: ShellModel, box: MaterialBox, band: tuple[float, float]) -> None:
    """ValueError for a plate, box or band that cannot be reduced."""
    if model.coupling.shape[1] == 0:
        raise ValueError("a plate with neither patch nor force has nothing to reduce to")
    (e0, e1), (n0, n1), (h0, h1) = box.youngs_modulus, box.poisson_ratio, box.loss_factor
    if not (0.0 < e0 <= e1 and 0.0 <= n0 <= n1 < 0.5 and 0.0 <= h0 <= h1 <= 1.0):
        raise ValueError(
            f"material box E {e0:g} to {e1:g} Pa, nu {n0:g} to {n1:g}, eta {h0:g} to {h1:g}: each must ascend, "
            "E above 0, nu within 0 to 0.5, eta within 0 to 1"
        )
    if not 0.0 <= band[0] < band[1]:
        raise ValueError(f"band {band[0]:g} to {band[1]:g} Hz must ascend from 0 or above")


def _candidates(
    model: ShellModel,
    dashpots: Real | None,
    box: MaterialBox,
    band: tuple[float, float],
    lines: Real,
    training: BasisTraining,
    report: Progress,
) -> Real:
    """Krylov vectors (n, N) of the softest materials, for the patches and for the forces of `dashpots` (n, q).

    Two shifts each, near the ends of the band: a third factorization costs as much as twenty more vectors.
    """
    shifts = band[0] + np.array(SHIFTS) * (band[1] - band[0])
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
            report(STAGE, 0.4 * (k + 1) / len(materials))
    return np.hstack(spaces)


def _corrections(
    model: ShellModel,
    vectors: Real,
    candidate: ReducedModel,
    materials: list[tuple[float, float]],
    lines: Real,
    training: BasisTraining,
) -> Real:
    """Missing parts (n, s) of the modes at some materials."""
    loss = training_loss(candidate.box)

    def missing(constants: tuple[float, float]) -> Real:
        return mode_corrections(
            model, vectors, candidate, constants, lines=lines, loss_factor=loss, tolerance=training.tolerance
        ).missing

    with ThreadPoolExecutor(WORKERS) as executor:
        return np.hstack(list(executor.map(missing, materials)))


def _extended(
    vectors: Real, missing: Real, known: ReducedModel, energy: csr_matrix, mass: csr_matrix, tail: float
) -> Real:
    """Add the leading missing parts to vectors, of which `known` is the projection; see `extended_basis`."""
    gram = known.stiffness(*middle(known.box), 0.0).real + energy_shift(known.band) * np.eye(known.size)
    with threadpool_limits(WORKERS, user_api="blas"):
        return extended_basis(vectors, missing, energy, mass, tail, gram=gram)


def _damped_responses(
    model: ShellModel, box: MaterialBox, band: tuple[float, float], training: BasisTraining
) -> Real:
    """Real and imaginary parts of responses (n, N) of a plate with dashpots along an edge over the box.

    Krylov spaces would be too large: every function of the edge would be a load.
    """
    lines = np.linspace(*band, DAMPED_LINES)

    def responses(constants: tuple[float, float]) -> Real:
        found = model.responses(*constants, training_loss(box), lines)
        return np.reshape([found.real, found.imag], (2, model.size, -1)).transpose(1, 0, 2).reshape(model.size, -1)

    with ThreadPoolExecutor(WORKERS) as executor:
        return np.hstack(list(executor.map(responses, chain.from_iterable(training.materials(box)))))
