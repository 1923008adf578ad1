"""Reduction of a plate over a box of materials and a band, with its error measured.

Two steps. Rational Krylov spaces at a few materials give candidates, cheap to make but too many.
A proper orthogonal decomposition, in the energy norm, of damped responses computed within those
candidates all over the box keeps about half of them, ordered by what they are worth.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike, NDArray
from scipy.stats import qmc

from analysis.material import MaterialBox
from simulation.modal_form import ModalForm
from simulation.rational_krylov import material_space, orthonormal, relative_error
from simulation.reduced_model import ReducedModel
from simulation.shell_model import ShellModel

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
Progress = Callable[[str, float], None]

STAGE = "reducing the plate"
LEAST_LOSS = 0.01  # an undamped plate has no finite response at resonance to train on


@dataclass(frozen=True)
class Training:
    """How a reduced model is made.

    Attributes
    ----------
    tolerance : float
        Error allowed, relative to a transfer's rms over the band.
    modulus_ratio, poisson_step : float
        Widest gaps between trained materials.
    lines : int
        Frequencies at which responses are compared and decomposed.
    rounds : int
        How often the candidates are enriched before the reduction is given up.
    """

    tolerance: float = 1e-4
    modulus_ratio: float = 5.0
    poisson_step: float = 0.2
    lines: int = 150
    rounds: int = 3


def reduce(
    model: ShellModel,
    box: MaterialBox,
    band: tuple[float, float],
    *,
    points: ArrayLike | None = None,
    training: Training | None = None,
    progress: Progress | None = None,
) -> ReducedModel:
    """Reduce `model` to what its patches can do within a box of materials and a band.

    Parameters
    ----------
    model : ShellModel
    box : MaterialBox
    band : (float, float)
        Hz.
    points : (K, 2) array_like, optional
        Where the deflection will be asked for, m.
    training : Training, optional
    progress : callable, optional
        Told the stage's name and the share done.

    Returns
    -------
    ReducedModel
        Its `error` is measured against the full model at materials outside the training.

    Raises
    ------
    RuntimeError
        If the tolerance cannot be reached.
    """
    training = training or Training()
    report = progress or (lambda stage, share: None)
    _check(model, box, band)
    lines = np.linspace(*band, training.lines)
    places = np.zeros((0, 2)) if points is None else np.atleast_2d(np.asarray(points, float))
    deflection = model.deflection(places) if len(places) else None
    vectors = _candidates(model, box, band, lines, training, report)
    for attempt in range(training.rounds):
        candidate, vectors = _projected(model, vectors, box, band)
        basis = _decomposed(candidate, lines, 0.25 * training.tolerance)
        small = _restricted(candidate, basis)
        if deflection is not None:
            small = replace(small, deflection=deflection @ (vectors @ basis), points=places)
        report(STAGE, 0.7 + 0.05 * attempt)
        error, seen = _measured(model, small, candidate, vectors @ basis, lines, attempt)
        report(STAGE, 0.8 + 0.05 * attempt)
        if error <= training.tolerance:
            report(STAGE, 1.0)
            return replace(small, error=error)
        vectors = np.hstack([vectors, seen.real, seen.imag])
    raise RuntimeError(
        f"the reduced model's error is {error:.2g} after {training.rounds} rounds; allowed {training.tolerance:g}"
    )


def trained_materials(box: MaterialBox, training: Training) -> list[tuple[float, float]]:
    """(E, nu) of a grid that covers the box, and of the middle of every cell."""
    (e0, e1), (n0, n1) = box.youngs_modulus, box.poisson_ratio
    cells_e = int(np.ceil(np.log(e1 / e0) / np.log(training.modulus_ratio) - 1e-6))
    cells_n = int(np.ceil((n1 - n0) / training.poisson_step - 1e-6))
    e, n = np.geomspace(e0, e1, cells_e + 1), np.linspace(n0, n1, cells_n + 1)
    grid = [(x, y) for x in e for y in n]
    middle = [(x, y) for x in np.sqrt(e[1:] * e[:-1]) for y in 0.5 * (n[1:] + n[:-1])]
    return [(float(x), float(y)) for x, y in grid + middle]


def _check(model: ShellModel, box: MaterialBox, band: tuple[float, float]) -> None:
    if model.coupling.shape[1] == 0:
        raise ValueError("a plate without patches has nothing to reduce to")
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
    box: MaterialBox,
    band: tuple[float, float],
    lines: Real,
    training: Training,
    report: Progress,
) -> Real:
    shifts = np.array([max(band[0], 0.05 * band[1]), 0.5 * sum(band), band[1]])
    materials = trained_materials(box, training)
    spaces = []
    for k, (e, nu) in enumerate(materials):
        report(STAGE, 0.6 * k / len(materials))
        spaces.append(
            material_space(
                model,
                e,
                nu,
                shifts=shifts,
                lines=lines,
                loss_factor=max(box.loss_factor[0], LEAST_LOSS),
                tolerance=0.1 * training.tolerance,
            )
        )
    return np.hstack(spaces)


def _projected(
    model: ShellModel, vectors: Real, box: MaterialBox, band: tuple[float, float]
) -> tuple[ReducedModel, Real]:
    """Galerkin model on candidate vectors, and the vectors orthonormal in the mass (n, N)."""
    e, nu = _middle(box)
    energy = model.stiffness(e, nu) + (2 * np.pi * max(band[0], 0.1 * band[1])) ** 2 * model.mass
    vectors = orthonormal(vectors, lambda x: energy @ x, cutoff=1e-6)
    root = scipy.linalg.cholesky(vectors.T @ (model.mass @ vectors), lower=True)
    vectors = scipy.linalg.solve_triangular(root, vectors.T, lower=True).T

    def projected(matrix: object) -> Real:
        small = vectors.T @ (matrix @ vectors)  # type: ignore[operator]
        return np.asarray(0.5 * (small + small.T))

    candidate = ReducedModel(
        stiffness_1=projected(model.stiffness_1),
        stiffness_2=projected(model.stiffness_2),
        stiffness_patch=projected(model.stiffness_patch),
        coupling=vectors.T @ model.coupling,
        capacitance=model.capacitance,
        box=box,
        band=band,
        error=float("inf"),
    )
    return candidate, vectors


def _decomposed(candidate: ReducedModel, lines: Real, tolerance: float) -> Real:
    """Fewest leading directions (N, r) of the responses all over the box that keep the tolerance.

    They are orthonormal in the mass, as the candidate's coordinates are.
    """
    box = candidate.box
    e, nu = _middle(box)
    shift = (2 * np.pi * max(candidate.band[0], 0.1 * candidate.band[1])) ** 2
    energy = candidate.stiffness(e, nu, 0.0).real + shift * np.eye(candidate.size)
    root = scipy.linalg.cholesky(energy, lower=True)
    loss = max(box.loss_factor[0], LEAST_LOSS)
    forms = [
        ModalForm.of(candidate.stiffness(x, y, loss))
        for x in np.geomspace(*box.youngs_modulus, 4)
        for y in np.linspace(*box.poisson_ratio, 3)
    ]
    snapshots = np.concatenate(
        [form.solve(candidate.coupling, lines).reshape(-1, candidate.size) for form in forms]
    )
    weighed = root.T @ np.hstack([snapshots.T.real, snapshots.T.imag])
    _, directions = np.linalg.eigh(weighed @ weighed.T)
    directions = scipy.linalg.solve_triangular(root.T, directions[:, ::-1], lower=False)
    references = [form.compliance(candidate.coupling, candidate.coupling, lines) for form in forms]
    materials = [
        (x, y, loss) for x in np.geomspace(*box.youngs_modulus, 4) for y in np.linspace(*box.poisson_ratio, 3)
    ]

    def good(size: int) -> bool:
        small = _restricted(candidate, np.linalg.qr(directions[:, :size])[0])
        return all(
            relative_error(small.compliance(*material, lines), reference) <= tolerance
            for material, reference in zip(materials, references, strict=True)
        )

    low, high = 0, candidate.size
    while high - low > 4:
        size = (low + high) // 2
        low, high = (low, size) if good(size) else (size, high)
    return np.asarray(np.linalg.qr(directions[:, :high])[0])


def _restricted(candidate: ReducedModel, basis: Real) -> ReducedModel:
    return replace(
        candidate,
        stiffness_1=basis.T @ candidate.stiffness_1 @ basis,
        stiffness_2=basis.T @ candidate.stiffness_2 @ basis,
        stiffness_patch=basis.T @ candidate.stiffness_patch @ basis,
        coupling=basis.T @ candidate.coupling,
        deflection=np.zeros((0, basis.shape[1])),
    )


def _middle(box: MaterialBox) -> tuple[float, float]:
    return float(np.sqrt(np.prod(box.youngs_modulus))), float(np.mean(box.poisson_ratio))


def _held_out(box: MaterialBox, attempt: int) -> list[tuple[float, float, float]]:
    """Materials between the trained ones: on the box's soft and stiff sides, lightly damped, and within."""
    (e0, e1), (n0, n1), (h0, h1) = box.youngs_modulus, box.poisson_ratio, box.loss_factor
    sides = [(e0, n0 + 0.55 * (n1 - n0), h0), (e1, n0 + 0.45 * (n1 - n0), h0)] if attempt == 0 else []
    cube = qmc.Halton(3, scramble=True, rng=np.random.default_rng(attempt)).random(4)
    within = [(e0 * (e1 / e0) ** a, n0 + b * (n1 - n0), h0 + c * (h1 - h0)) for a, b, c in cube]
    return [(float(e), float(n), float(h)) for e, n, h in sides + within]


def _measured(
    model: ShellModel, small: ReducedModel, candidate: ReducedModel, basis: Real, lines: Real, attempt: int
) -> tuple[float, Complex]:
    """Largest relative error against the full model at held-out materials, and the full responses.

    Each material is solved at two lines: the one where `small` and `candidate` disagree most, and
    one drawn from the band.
    """
    rng = np.random.default_rng(100 + attempt)
    worst, seen = 0.0, []
    for material in _held_out(small.box, attempt):
        over_band = small.compliance(*material, lines)
        rms = np.sqrt(np.mean(np.abs(over_band) ** 2, axis=-1))
        finer = candidate.compliance(*material, lines)
        peak = (np.abs(over_band - finer) / rms[..., None]).max(axis=(0, 1)).argmax()
        chosen = np.array([lines[peak], rng.uniform(*small.band)])
        full = model.responses(*material, chosen)
        transfer = np.einsum("ni,nkf->ikf", model.coupling, full)
        wrong = np.abs(small.compliance(*material, chosen) - transfer) / rms[..., None]
        worst = max(worst, float(wrong.max()))
        if len(small.points):
            field = model.deflection(small.points) @ full.reshape(model.size, -1)
            reduced = small.deflection @ small.amplitudes(*material, chosen).transpose(2, 0, 1).reshape(
                small.size, -1
            )
            over_field = small.deflection @ small.amplitudes(*material, lines).transpose(2, 0, 1).reshape(
                small.size, -1
            )
            scale = np.sqrt(np.mean(np.abs(over_field) ** 2))
            worst = max(worst, float(np.abs(field + reduced).max() / scale))
        seen.append(full.reshape(model.size, -1))
    return worst, np.hstack(seen)
