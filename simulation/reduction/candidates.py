"""Vectors from which a reduced model's are chosen: Krylov spaces, corrections of modes, damped responses."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import chain

import numpy as np

from analysis.arrays import Real
from analysis.material import MaterialBox
from simulation.reduction.basis_training import BasisTraining
from simulation.reduction.energy_decomposition import training_loss
from simulation.reduction.mode_corrections import mode_corrections
from simulation.reduction.rational_krylov import material_space
from simulation.reduction.reduced_model import ReducedModel
from simulation.shell.shell_model import ShellModel

WORKERS = 2
"""Number of materials solved at a time, in threads: sparse factorization releases the interpreter lock."""
SHIFTS_IN_BAND = (0.2, 0.9)
"""Shifts in the band at which a material's stiffness is factorized."""
DAMPED_LINES = 16
"""Number of frequencies per material at which a plate with dashpots is solved."""


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
