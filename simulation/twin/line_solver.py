"""Solution for a plate whose stiffness, mass or damping changes from line to line."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real, Whole
from simulation.reduction.composition import Composite, proportion
from simulation.reduction.modal_form import ModalForm
from simulation.state.plate_state import SPECTRA, PlateState
from simulation.twin.local_plate import LocalPlate

ITERATIONS = 12
"""Largest number of iterations, which takes as long as a direct solution, used for lines not converged."""
CONVERGED_STEP = 1e-13
"""Relative size of the last step at convergence; the error left is smaller than this step."""
LINES_OF_ONE_MEAN = 256
"""Number of lines in the modes of one mean stiffness, if all lines are solved."""
LINES_AT_ONCE = 64
"""Number of lines factorized at a time."""


@dataclass(frozen=True)
class LineSolver:
    """Z**-1 over a band, in the complex modes of its mean stiffness.

    In these modes Z has a diagonal that is exact at every line, and small off-diagonal terms: the coupling by the
    patches' stiffness times the deviation of a line from the mean. So an iteration with the diagonal as
    preconditioner gains one to two digits per step, at a tenth of the cost of a factorization.

    Attributes
    ----------
    modes : ModalForm
        Of the mean stiffness, without dashpots, in local coordinates.
    omega2 : (F,) ndarray
        Angular frequency squared, rad2/s2.
    mean : (float, float)
        Factors of storage and loss whose modes these are.
    ratio : float or None
        Loss factor, where the plate has one everywhere.
    terms : tuple of (m, m) complex ndarray
        In these modes: stiffness, its loss (unless given by `ratio`), normal mass, dashpots (if there are any).
    """

    modes: ModalForm
    omega2: Real
    mean: tuple[float, float]
    ratio: float | None
    terms: tuple[Complex, ...]

    @classmethod
    def of(cls, plate: LocalPlate, state: PlateState, frequency: Real) -> Self:
        """Prepare from the mean factors and the point dampers of a state.

        Parameters
        ----------
        frequency : (F,) ndarray, Hz

        Returns
        -------
        LineSolver
        """
        local: Composite = plate.composite
        mean = float(np.mean(state.storage)), float(np.mean(state.loss))
        stiffness = mean[0] * local.plate + 1j * mean[1] * local.plate_loss + local.fixed
        modes = ModalForm.of(stiffness.astype(complex))
        ratio = proportion(local.plate_loss, local.plate)
        dashpots = plate.dashpots(state)
        matrices = [local.plate, *([local.plate_loss] if ratio is None else []), plate.normal]
        matrices += [dashpots] if dashpots.any() else []
        terms = tuple(modes.inverse @ (matrix @ modes.shapes) for matrix in matrices)
        return cls(modes, (2 * np.pi * frequency) ** 2, mean, ratio, terms)

    def weights(self, state: PlateState) -> list[Complex]:
        """Factors (F,) of the `terms` in a state that differs only by its factors over frequency."""
        omega = np.sqrt(self.omega2)
        stored, lost = state.storage - self.mean[0], 1j * (state.loss - self.mean[1])
        air = 1j * omega * state.area_resistance - self.omega2 * state.area_mass
        stiffness = [stored, lost] if self.ratio is None else [stored + self.ratio * lost]
        found = [np.asarray(weight, complex) for weight in (*stiffness, air, 1j * omega)]
        return found[: len(self.terms)]

    def solve(self, weights: list[Complex], right: Complex, lines: Whole) -> Complex:
        """Solve Z x = right at some lines, both sides in the complex modes.

        Parameters
        ----------
        weights : list of (F,) complex ndarray
            Of each of `terms`, at all lines.
        right : (m, n) complex ndarray
            One column for each of `lines`.
        lines : (n,) ndarray of int

        Returns
        -------
        (m, n) complex ndarray
        """
        used = [(w[lines], term) for w, term in zip(weights, self.terms, strict=True) if w[lines].any()]
        apart = self.modes.poles[:, None] - self.omega2[lines]
        diagonal = apart + sum((w * np.diagonal(term)[:, None] for w, term in used), np.zeros_like(apart))
        x = right / diagonal
        if not used:
            return np.asarray(x)
        left = np.arange(lines.size)
        for _ in range(ITERATIONS):
            there = x[:, left]
            step = right[:, left] - apart[:, left] * there
            for w, term in used:
                step -= w[left] * (term @ there)
            step /= diagonal[:, left]
            x[:, left] = there + step
            left = left[np.linalg.norm(step, axis=0) > CONVERGED_STEP * np.linalg.norm(there, axis=0)]
            if not left.size:
                return np.asarray(x)
        for start in range(0, left.size, LINES_AT_ONCE):
            part = left[start : start + LINES_AT_ONCE]
            z = apart[:, part].T[:, :, None] * np.eye(len(apart))
            z += sum(w[part, None, None] * term for w, term in used)
            x[:, part] = np.linalg.solve(z, right[:, part].T[..., None])[..., 0].T
        return np.asarray(x)

    def into(self, local: NDArray[Any]) -> Complex:
        """Transform a right-hand side (m, ...) from local coordinates to the modes."""
        return np.asarray(self.modes.inverse @ local)

    def back(self, found: Complex) -> Complex:
        """Transform solutions (m, ...) from the modes to local coordinates."""
        return np.asarray(self.modes.shapes @ found)


def solved_by_lines(plate: LocalPlate, state: PlateState, frequency: Real) -> Complex:
    """Z**-1 b of every port over the band.

    Parameters
    ----------
    state : PlateState
        Its spectra at all lines.
    frequency : (F,) ndarray, Hz

    Returns
    -------
    (m, P, F) complex ndarray
    """
    coupling = plate.composite.coupling
    answers = np.empty((*coupling.shape, frequency.size), complex)
    for start in range(0, frequency.size, LINES_OF_ONE_MEAN):
        part = slice(start, start + LINES_OF_ONE_MEAN)
        there = state.with_(**{name: getattr(state, name)[part] for name in SPECTRA})
        solver = LineSolver.of(plate, there, frequency[part])
        count = solver.omega2.size
        right = np.repeat(solver.into(coupling), count, axis=1)
        lines = np.tile(np.arange(count), coupling.shape[1])
        found = solver.back(solver.solve(solver.weights(there), right, lines))
        answers[..., part] = found.reshape(*coupling.shape, count)
    return answers
