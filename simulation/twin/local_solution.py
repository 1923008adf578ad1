"""Responses of a plate in one state over a band; stiffness, mass or damping may change from line to line."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real, Whole
from simulation.reduction.composition import Composite, proportion
from simulation.reduction.modal_form import ModalForm, PoleSums, forces
from simulation.state.attached import Seat
from simulation.state.plate_state import SPECTRA, PlateState
from simulation.twin.local_plate import KEPT_MODES_FACTOR, LoadedPlate, LocalPlate

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


PORTS_AT_ONCE = 32
"""Ports solved at a time: on the way each takes several times the memory of its answer."""
MOST_DASHPOTS = 12
"""Directions of damping up to which modes are used: the cost of connecting them grows with their square."""


@dataclass(frozen=True)
class LocalSolution:
    """Z**-1 b of every port over the band, for one state.

    Attributes
    ----------
    frequency : (F,) ndarray
        Hz.
    plate : LocalPlate
    state : PlateState
    modal : ModalForm or None
        Used if only -w**2, few dashpots and what is attached change over the band; None for other states.
    by_lines : (m, P, F) ndarray or None
        Z**-1 b of the other states.
    """

    frequency: Real
    plate: LocalPlate
    state: PlateState
    modal: ModalForm | None
    by_lines: Complex | None = None

    @classmethod
    def of(
        cls,
        ops: LoadedPlate,
        whole: Composite,
        state: PlateState,
        frequency: Real,
        reach: float = KEPT_MODES_FACTOR,
    ) -> Self:
        """Choose local coordinates and solve.

        Parameters
        ----------
        whole : Composite
            In all r coordinates, without the state's point loads.
        frequency : (F,) ndarray, Hz
        reach : float
            Modes are taken up to `reach` times the band's end; all of them if infinite.

        Returns
        -------
        LocalSolution
        """
        return cls._of(LocalPlate.of(ops, whole, state, reach), state, frequency)

    def likewise(self, plate: LocalPlate) -> Self:
        """Solve another plate in the same state over the same lines."""
        return self._of(plate, self.state, self.frequency)

    @classmethod
    def _of(cls, plate: LocalPlate, state: PlateState, frequency: Real) -> Self:
        modal = _modal(plate, state)
        if any(one.acts for one in state.attached):
            rows, z = _seats(plate, state)
            if modal is None:
                return cls(frequency, plate, state, None, _attached(plate, state, frequency, rows, z))
            if frequency.size == 1 and not modal.count:
                return cls(frequency, plate, state, _modal(plate, state, (rows, z)))
            return cls(frequency, plate, state, modal.with_attached(rows, z))
        return cls(frequency, plate, state, modal, None if modal else solved_by_lines(plate, state, frequency))

    @property
    def basis(self) -> Real:
        """Of `plate`."""
        return self.plate.basis

    @property
    def composite(self) -> Composite:
        """Of `plate`."""
        return self.plate.composite

    @property
    def normal(self) -> Real:
        """Of `plate`."""
        return self.plate.normal

    @property
    def operators(self) -> LoadedPlate:
        """Of `plate`."""
        return self.plate.operators

    @cached_property
    def sums(self) -> PoleSums | None:
        """Of the modes over the band; None without them."""
        return None if self.modal is None else PoleSums.of(self.modal.poles, self.frequency)

    @cached_property
    def answers(self) -> Complex:
        """Z**-1 b, (m, P, F)."""
        if self.modal is None or self.by_lines is not None:
            return np.asarray(self.by_lines)
        return np.ascontiguousarray(self.modal.solve(self.composite.coupling, self.frequency).transpose(2, 0, 1))

    def compliance(self, seen: Sequence[int] | None = None, driving: Sequence[int] | None = None) -> Complex:
        """b_i' Z**-1 b_j between ports `seen` (I,) and `driving` (J,), all unless given: (I, J, F), C/V."""
        coupling = self.composite.coupling
        rows, columns = (range(coupling.shape[1]) if some is None else some for some in (seen, driving))
        left, right = coupling[:, list(rows)], coupling[:, list(columns)]
        if self.modal is not None:
            return self.modal.compliance(left, right, self.frequency, self.sums)
        answers = self.answers[:, list(columns)]
        return np.asarray((left.T @ answers.reshape(len(left), -1)).reshape(-1, *answers.shape[1:]))

    def driven(self, drive: Complex) -> Complex:
        """Z**-1 b drive, (m, F), of amounts (P, F) at all ports."""
        return np.asarray(np.einsum("mpf,pf->mf", self.answers, drive))

    def felt(self, forces: Complex) -> Complex:
        """Return b' Z**-1 force, (D, P, F), of D forces (D, m, F) in local coordinates."""
        found = np.empty((len(forces), self.answers.shape[1], self.frequency.size), complex)
        for start in range(0, self.frequency.size, LINES_OF_ONE_MEAN):
            part = slice(start, start + LINES_OF_ONE_MEAN)
            by_line = self.answers[..., part].transpose(2, 1, 0) @ forces[..., part].transpose(2, 1, 0)
            found[..., part] = by_line.transpose(2, 1, 0)
        return found


def _attached(plate: LocalPlate, state: PlateState, frequency: Real, rows: Real, z: Complex) -> Complex:
    """Z**-1 b of every port, (m, P, F), with attachments at `rows` (k, m), of stiffness `z` (k, F), by lines."""
    local = plate.composite
    count = local.coupling.shape[1]
    loads = np.hstack([local.coupling, rows.T])
    answers = solved_by_lines(replace(plate, composite=replace(local, coupling=loads)), state, frequency)
    moved = np.einsum("km,mpf->kpf", rows, answers)
    held = forces(moved[:, count:], moved[:, :count], z)
    answers, there = answers[:, :count], answers[:, count:]
    for first in range(0, count, PORTS_AT_ONCE):
        some = slice(first, first + PORTS_AT_ONCE)
        answers[:, some] -= np.einsum("mkf,kpf->mpf", there, held[:, some])
    return answers


def _seats(plate: LocalPlate, state: PlateState) -> tuple[Real, Complex]:
    """Rows (k, m) of the deflection at a state's attachments, and their stiffness as felt, (k, F)."""
    seats = [Seat.of(plate.operators, one, state) for one in state.attached if one.acts]
    rows = np.array([np.real(seat.row) for seat in seats]) @ plate.basis
    return rows, np.array([np.real(seat.stiffness) + 1j * np.real(seat.loss) for seat in seats])


def _modal(plate: LocalPlate, state: PlateState, attached: tuple[Real, Complex] | None = None) -> ModalForm | None:
    """Modes of a state whose stiffness, mass and few dashpots are the same at all lines; None for others.

    `attached`, as of `_seats` at a single line, is added to the stiffness.
    """
    varying = (state.area_mass, state.area_resistance)
    if any(s.any() for s in varying) or not _constant((state.storage, state.loss)):
        return None
    dashpots = plate.dashpots(state)
    power, directions = np.linalg.eigh(dashpots) if dashpots.any() else (np.zeros(0), np.zeros((len(dashpots), 0)))
    felt = power > 1e-13 * power.max(initial=0.0)
    if felt.sum() > MOST_DASHPOTS:
        return None
    local = plate.composite
    stiffness = state.storage[0] * local.plate + 1j * state.loss[0] * local.plate_loss + local.fixed
    if attached is not None:
        rows, z = attached
        stiffness = stiffness + (rows.T * z[:, 0]) @ rows
    return ModalForm.of(stiffness, directions[:, felt] * np.sqrt(power[felt]))


def _constant(spectra: Iterable[Real]) -> bool:
    return all(np.ptp(s) == 0.0 for s in spectra)


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
