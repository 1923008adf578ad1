"""Corrections of a candidate space at a further material: what its modes there leave unbalanced.

The modes of the projected plate are nearly those of the full one. Their residuals, solved with the factors of
the dynamic stiffness at one shift, give the missing part of every mode: one step of Davidson's method (J. Comput.
Phys. 17, 1975). All are solved together, in half the time of as many Krylov vectors.
"""

import numpy as np

from analysis.arrays import Complex, Real
from simulation.reduction.damped_modes import DampedModes
from simulation.reduction.energy_decomposition import energy_shift
from simulation.reduction.reduced_model import ReducedModel
from simulation.reduction.resonance_lines import root_mean_square
from simulation.shell.factors import factorize
from simulation.shell.shell_model import ShellModel

SHIFT = 0.7
"""Shift in the band at which the stiffness is factorized: above the middle, where modes are most in error."""
BEYOND = 0.3
"""Margin above the band, as a share of its end, of the modes corrected. They are within the band for the softer
materials before the next: with a margin of 0.05 errors there were 40 times as large."""


def mode_corrections(
    model: ShellModel,
    vectors: Real,
    candidate: ReducedModel,
    material: tuple[float, float],
    *,
    lines: Real,
    loss_factor: float,
    tolerance: float,
) -> Real:
    """Missing parts of the modes, and of the responses at the shift, at one material.

    A part d missing of a mode of stiffness lambda makes lambda too large by d'Kd, and the transfers at this
    resonance wrong by d'Kd / (lambda loss_factor) of the peak. Modes whose peak is below `tolerance` are left out.

    Parameters
    ----------
    model : ShellModel
        Of n unknowns.
    vectors : (n, N) ndarray
        Orthonormal in the mass.
    candidate : ReducedModel
        Projection of `model` onto them.
    material : (float, float)
        E, Pa, and nu.
    lines : (F,) ndarray, Hz
        Even grid over the band.
    loss_factor : float
        Smallest of the material.
    tolerance : float
        Of any transfer, relative to its rms over the band.

    Returns
    -------
    (n, s) ndarray
        The squared norm of each, in the plate's energy, is the error of transfers without it times the loss
        factor.
    """
    modes = candidate.damped_modes(*material)
    peak = _peaks(modes, lines, loss_factor)
    highest = 2 * np.pi * (1.0 + BEYOND) * lines[-1]
    chosen = np.flatnonzero((np.abs(modes.squares) < highest**2) & (peak > tolerance))
    stiffness = model.stiffness(*material)
    shapes, squares = vectors @ modes.shapes[:, chosen], modes.squares[chosen]
    residuals = stiffness @ shapes - (model.mass @ shapes) * squares
    omega2 = float(2 * np.pi * (lines[0] + SHIFT * (lines[-1] - lines[0]))) ** 2
    factors = factorize(stiffness - omega2 * model.mass)
    missing = factors.solve(np.hstack([residuals, model.coupling]))
    size = np.maximum(np.abs(squares), energy_shift(candidate.band))
    responses = modes.force / (modes.squares - omega2)[:, None]
    energy = np.einsum("rp,r->p", responses**2, np.abs(modes.squares))
    return np.asarray(missing * np.sqrt(np.concatenate([peak[chosen] / size, 1.0 / energy])))


def _peaks(modes: DampedModes, lines: Real, loss_factor: float) -> Real:
    """Largest transfer (r,) that each mode alone has at its resonance, over that transfer's rms over the band."""
    over = modes.lines(loss_factor, lines)
    transfers: Complex = modes.transfers(over, loss_factor)
    rms = root_mean_square(transfers, over)
    strength = np.abs(modes.force[:, :, None] * modes.force[:, None, :]) / rms
    lowest = (2 * np.pi * lines[0]) ** 2
    return np.asarray(strength.max(axis=(1, 2)) / (loss_factor * np.maximum(np.abs(modes.squares), lowest)))
