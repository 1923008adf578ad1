"""Corrections of a basis at a further material: what its modes leave unbalanced, and the error that it makes.

The modes of the projected plate are nearly those of the full one. Their residuals, solved with the factors of
the dynamic stiffness at one shift, give the missing part of every mode: one step of Davidson's method (J. Comput.
Phys. 17, 1975). All are solved together, in half the time of as many Krylov vectors.
"""

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Real
from simulation.reduction.damped_modes import DampedModes
from simulation.reduction.reduced_model import ReducedModel
from simulation.reduction.vectors.energy_decomposition import energy_shift
from simulation.reduction.vectors.resonance_lines import root_mean_square
from simulation.shell.shell_model import ShellModel
from simulation.shell.unknowns import factorize

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
