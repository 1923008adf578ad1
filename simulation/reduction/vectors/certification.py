"""Error of a reduced model, measured against the full one outside the training set.

Corrections of a basis at a further material: what its modes leave unbalanced, and the error that it makes.

The modes of the projected plate are nearly those of the full one. Their residuals, solved with the factors of
the dynamic stiffness at one shift, give the missing part of every mode: one step of Davidson's method (J. Comput.
Phys. 17, 1975). All are solved together, in half the time of as many Krylov vectors.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Complex, Real
from analysis.material import MaterialBox
from simulation.reduction.damped_modes import DampedModes, root_mean_square
from simulation.reduction.reduced_model import ReducedModel
from simulation.reduction.vectors.energy_decomposition import BAND_MARGIN, energy_shift, training_loss
from simulation.shell.shell_model import ShellModel
from simulation.shell.unknowns import factorize

Constants = tuple[float, float, float]

WORKERS = 2
"""Materials solved at a time."""
MATERIALS_DRAWN = 2
"""Number of random materials in the box at each attempt."""
HALTON = (2, 3)
"""Bases of Halton's sequence along E and nu."""


@dataclass(frozen=True)
class MeasuredError:
    """Error of a reduced model, and what to add to its vectors (n unknowns) if it is too large.

    Attributes
    ----------
    error : float
        As `ReducedModel.error`.
    seen : (n, S) complex ndarray
        Responses of the full model: minus the displacements per volt.
    missing : (n, s) ndarray
        See `ModeCorrections`.
    """

    error: float
    seen: Complex
    missing: Real


def held_out(box: MaterialBox, attempt: int) -> list[tuple[float, float]]:
    """(E, nu) between the training materials, two of them random, new ones at each attempt.

    The first attempt also uses the box's softest material, where resonances are most numerous, and a stiffest one:
    the first, which takes longest, and the last of them.
    """
    (e0, e1), (n0, n1) = box.youngs_modulus, box.poisson_ratio
    square = _scattered(MATERIALS_DRAWN, np.random.default_rng(attempt))
    found = [(e0 * (e1 / e0) ** a, n0 + b * (n1 - n0)) for a, b in square]
    if attempt == 0:
        found = [(e0, n0 + 0.37 * (n1 - n0)), *found, (e1, n0)]
    return [(float(e), float(n)) for e, n in found]


def _scattered(count: int, rng: np.random.Generator) -> Real:
    """Points (count, 2) of the unit square, far from each other: Halton's sequence, shifted at random.

    Written here, because importing SciPy's takes a second.
    """
    digits = 8
    found = np.empty((count, len(HALTON)))
    for axis, base in enumerate(HALTON):
        places = np.arange(1, count + 1)[:, None] // base ** np.arange(digits) % base
        found[:, axis] = (places / float(base) ** np.arange(1, digits + 1)).sum(axis=1)
    return np.asarray((found + rng.random(len(HALTON))) % 1.0)


def measured_error(
    model: ShellModel, small: ReducedModel, vectors: Real, lines: Real, attempt: int, tolerance: float
) -> MeasuredError:
    """Measure the error of `small` at the held-out materials, with the least damping, where it is largest.

    The full model is solved for each material at the resonance where the corrections of the modes say that the
    error is largest, and for the first one also at a random one of `lines` and those on narrow resonances.

    Parameters
    ----------
    model : ShellModel
        The full model, of n unknowns.
    vectors : (n, r) ndarray
        Of its coordinates.
    lines : (F,) ndarray, Hz
        Evenly spaced over the band.
    attempt : int
        Number of the attempt, which is the seed of random materials and frequencies.
    tolerance : float
        Of the error.
    """
    loss = training_loss(small.box)
    materials = held_out(small.box, attempt)
    rng = np.random.default_rng(100 + attempt)

    def at(place: int) -> MeasuredError:
        moduli = materials[place]
        found = mode_corrections(
            model, vectors, small, moduli, lines=lines, loss_factor=loss, tolerance=tolerance, beyond=BAND_MARGIN
        )
        within = (found.frequency > lines[0]) & (found.frequency < lines[-1])
        worst = found.frequency[np.where(within, found.error, 0.0).argmax()] if within.any() else lines[-1]
        drawn = rng.choice(found.lines) if place == 0 else worst
        chosen = np.unique([worst, drawn])
        full = model.responses(*moduli, loss, chosen)
        reduced = _responses(small, (*moduli, loss), chosen)
        wrong = small.coupling.T @ reduced - np.einsum("ni,nkf->fik", model.coupling, full)
        error = float((np.abs(wrong) / found.rms).max())
        error = max(error, _field_error(model, small, (*moduli, loss), full, reduced, found.lines))
        return MeasuredError(error, full.reshape(model.size, -1), found.missing)

    with ThreadPoolExecutor(WORKERS) as executor:
        parts = list(executor.map(at, range(len(materials))))
    return MeasuredError(
        max(part.error for part in parts),
        np.hstack([part.seen for part in parts]),
        np.hstack([part.missing for part in parts]),
    )


def _responses(small: ReducedModel, material: Constants, frequency: Real) -> Complex:
    """Z**-1 b of the reduced model for every patch, (F, r, P): solved directly, its poles are not needed."""
    stiffness, damping = small.stiffness(*material), small.dashpots @ small.dashpots.T
    omega = 2 * np.pi * frequency[:, None, None]
    dynamic = stiffness + 1j * omega * damping - omega**2 * np.eye(small.size)
    return np.asarray(np.linalg.solve(dynamic, small.coupling.astype(complex)))


def _field_error(
    model: ShellModel, small: ReducedModel, material: Constants, full: Complex, reduced: Complex, lines: Real
) -> float:
    """Largest rms over the points of the deflection's error, over its rms over points, inputs and band.

    Responses of the full model are (n, P, F), those of the reduced one (F, r, P).
    """
    if not len(small.points):
        return 0.0
    field = (model.deflection(small.points) @ full.reshape(model.size, -1)).reshape(-1, *full.shape[1:])
    wrong = np.sqrt(np.mean(np.abs(field - np.einsum("kr,frn->knf", small.deflection, reduced)) ** 2, axis=0))
    over_band = np.einsum("kr,nfr->knf", small.deflection, small.amplitudes(*material, lines), optimize=True)
    return float(wrong.max() / np.sqrt(np.mean(root_mean_square(over_band, lines) ** 2)))


SHIFT_IN_BAND = 0.7
"""Shift in the band at which the stiffness is factorized: above the middle, where modes are most in error."""
CANDIDATE_MARGIN = 0.3
"""Margin for candidates. Modes there are within the band for the softer materials before the next: with a margin
of 0.05 errors were 40 times as large."""
LEAST_PEAK = 0.2
"""Least peak, over the rms, that every mode is corrected for. A mode that hardly moves the patches at one material
does at another, where it crosses a neighbour's frequency: with 0.03 an in-plane mode made errors of 7e-4 there."""
NEGLIGIBLE_ERROR = 0.01
"""Errors below this share of the tolerance are left: corrections would only cost products of large matrices."""


@dataclass(frozen=True)
class ModeCorrections:
    """Missing parts of the modes at one material.

    Attributes
    ----------
    missing : (n, s) ndarray
        Of modes known badly, then the responses to all loads at the shift. The squared norm of each, in the
        plate's energy, is the error of transfers without it times the loss factor.
    frequency : (m,) ndarray, Hz
        Of the modes, ascending.
    error : (m,) ndarray
        Estimate of the largest error of a transfer at each resonance, over the transfer's rms: within a few
        percent of the true one where that is small.
    lines : (F,) ndarray, Hz
        That resolve every resonance within the band.
    rms : (P, P) ndarray
        Of the transfers between patches over the band, with lossy patches.
    """

    missing: Real
    frequency: Real
    error: Real
    lines: Real
    rms: Real


def mode_corrections(
    model: ShellModel,
    vectors: Real,
    reduced: ReducedModel,
    material: tuple[float, float],
    *,
    lines: Real,
    loss_factor: float,
    tolerance: float,
    beyond: float = CANDIDATE_MARGIN,
) -> ModeCorrections:
    """Missing parts of the modes, and of the responses at the shift, at one material.

    A part d missing of a mode of stiffness lambda makes lambda too large by d'Kd, and the transfers at this
    resonance wrong by d'Kd / (lambda loss_factor) of the peak.

    Parameters
    ----------
    model : ShellModel
        Of n unknowns.
    vectors : (n, N) ndarray
        Orthonormal in the mass.
    reduced : ReducedModel
        Projection of `model` onto them.
    material : (float, float)
        E, Pa, and nu.
    lines : (F,) ndarray, Hz
        Even grid over the band.
    loss_factor : float
        Smallest of the material.
    tolerance : float
        Of any transfer, relative to its rms over the band.
    beyond : float
        Margin above the band, as a share of its end, of the modes corrected.
    """
    modes = reduced.damped_modes(*material)
    over = modes.lines(loss_factor, lines)
    rms = root_mean_square(modes.transfers(over, loss_factor), over)
    peak = _peaks(modes, rms, lines[0], loss_factor)
    highest = 2 * np.pi * (1.0 + beyond) * lines[-1]
    chosen = np.flatnonzero(np.abs(modes.squares) < highest**2)
    stiffness = model.stiffness(*material)
    shapes, squares = vectors @ modes.shapes[:, chosen], modes.squares[chosen]
    residuals = stiffness @ shapes - (model.mass @ shapes) * squares
    omega2 = float(2 * np.pi * (lines[0] + SHIFT_IN_BAND * (lines[-1] - lines[0]))) ** 2
    factors = factorize(stiffness - omega2 * model.mass)
    missing = factors.solve(np.hstack([residuals, model.coupling]))
    size = np.maximum(np.abs(squares), energy_shift(reduced.band))
    shift = np.abs(np.einsum("ni,ni->i", residuals, missing[:, : chosen.size])) / (size * loss_factor)
    weight = np.maximum(peak[chosen], LEAST_PEAK)
    responses = modes.force / (modes.squares - omega2)[:, None]
    strain = np.einsum("rp,r->p", responses**2, np.abs(modes.squares))
    kept = np.append(weight * shift > NEGLIGIBLE_ERROR * tolerance, np.ones(strain.size, bool))
    scale = np.sqrt(np.concatenate([weight / size, 1.0 / strain]))
    frequency = np.sqrt(np.abs(squares)) / (2 * np.pi)
    return ModeCorrections(missing[:, kept] * scale[kept], frequency, peak[chosen] * shift, over, rms)


def _peaks(modes: DampedModes, rms: Real, lowest: float, loss_factor: float) -> Real:
    """Largest transfer (r,) that each mode alone has at its resonance, over its rms (P, P) over the band.

    Modes below the `lowest` line, Hz, count as if they were there.
    """
    strength = np.abs(modes.force[:, :, None] * modes.force[:, None, :]) / rms
    squares = np.maximum(np.abs(modes.squares), (2 * np.pi * lowest) ** 2)
    return np.asarray(strength.max(axis=(1, 2)) / (loss_factor * squares))
