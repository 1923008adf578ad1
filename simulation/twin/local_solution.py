"""Responses of a plate in one state over a band, in reduced coordinates for this state and band.

Between many ports of a plate of known modes with attachments, what acts is asked for, not all responses at once.
Each attachment changes Z by rank one. With the modes of Z0, the rows R of the deflection at the attachments and
their stiffness z as felt (Woodbury),

    b' Z**-1 f = b' Z0**-1 f - b' Z0**-1 R' (1 + z R Z0**-1 R')**-1 z R Z0**-1 f

for any force f. The responses Z**-1 b of a scan's hundreds of ports are never formed: of 200 ports, in 150
coordinates and at 1080 lines, they are 0.5 GB and took most of the time of a derivative.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np

from analysis.arrays import Complex, Real
from simulation.reduction.composition import Composite
from simulation.reduction.modal_form import ModalForm
from simulation.reduction.pole_sums import PoleSums
from simulation.state.attached import Seat
from simulation.state.plate_state import PlateState
from simulation.twin.line_solver import solved_by_lines
from simulation.twin.local_basis import KEPT_MODES_FACTOR
from simulation.twin.local_plate import LocalPlate
from simulation.twin.reduced_plate import LoadedPlate

PORTS_AT_ONCE = 32
"""Ports solved at a time: on the way each takes several times the memory of its answer."""
MOST_DASHPOTS = 12
"""Directions of damping up to which modes are used: the cost of connecting them grows with their square."""


LEAST_PORTS = 32
"""Ports from which this pays: a derivative takes two products with the modes' shapes, whatever the number of
ports, in place of one with the responses of each."""


@dataclass(frozen=True)
class SeatedModes:
    """Modes of a plate without dashpots, and what is attached to it.

    Attributes
    ----------
    form : ModalForm
        Without the attachments.
    frequency : (F,) ndarray
        Hz.
    rows : (k, m) ndarray
        Deflection at the attachments.
    stiffness : (k, F) complex ndarray
        As felt, N/m.
    """

    form: ModalForm
    frequency: Real
    rows: Real
    stiffness: Complex

    @cached_property
    def terms(self) -> Complex:
        """1/(pole - w**2), (m, F)."""
        square = (2 * np.pi * self.frequency) ** 2
        return np.asarray(1.0 / (self.form.poles[:, None] - square))

    @cached_property
    def _seen(self) -> Complex:
        """Rows in the modes' coordinates, (k, m)."""
        return np.asarray(self.rows @ self.form.shapes)

    @cached_property
    def _between(self) -> Complex:
        """1 + z R Z0**-1 R', (F, k, k)."""
        own = self._plain(self.rows, self.rows)
        return np.moveaxis(self.stiffness[:, None] * own, -1, 0) + np.eye(len(self.rows))

    def _plain(self, left: Real, right: Real) -> Complex:
        """Left rows (I, m), forces (J, m): I times Z0**-1 J', (I, J, F)."""
        a, b = left @ self.form.shapes, self.form.inverse @ right.T
        sums = (a[:, None] * b.T[None]).reshape(-1, len(self.terms)) @ self.terms
        return np.asarray(sums.reshape(len(left), len(right), -1))

    def _held(self, reached: Complex) -> Complex:
        """Return the forces of attachments, (k, J, F), where the plate alone would move by `reached` (k, J, F)."""
        felt = np.moveaxis(self.stiffness[:, None] * reached, -1, 0)
        forces: Complex = np.asarray(np.linalg.solve(self._between, felt), dtype=complex)
        return np.moveaxis(forces, 0, -1)

    def compliance(self, left: Real, right: Real) -> Complex:
        """Return a' Z**-1 b for every column a of `left` (m, I) and b of `right` (m, J), (I, J, F)."""
        whole = self._plain(np.vstack([left.T, self.rows]), np.vstack([right.T, self.rows]))
        count, forces = left.shape[1], right.shape[1]
        held = self._held(whole[count:, :forces])
        return np.asarray(whole[:count, :forces] - np.einsum("ikf,kjf->ijf", whole[:count, forces:], held))

    def field(self, load: Complex | Real) -> Complex:
        """Z**-1 load, (m, F), of forces (m, F) in the plate's coordinates, or (m, 1) at all lines."""
        return np.asarray(self.form.shapes @ self._modal_field(load))

    def felt(self, ports: Real, load: Complex | Real) -> Complex:
        """Motion b' Z**-1 load of every column b of `ports` (m, P), (P, F)."""
        return np.asarray((ports.T @ self.form.shapes) @ self._modal_field(load))

    def _modal_field(self, load: Complex | Real) -> Complex:
        """Z**-1 load in the modes' coordinates, (m, F)."""
        free = (self.form.inverse @ load) * self.terms
        held = self._held((self._seen @ free)[:, None])[:, 0]
        return np.asarray(free - ((self.form.inverse @ self.rows.T) @ held) * self.terms)


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
        Used if only -w**2 and few dashpots change over the band, and nothing is attached; None for other states.
    by_lines : (m, P, F) ndarray or None
        Z**-1 b of the other states.
    seated : SeatedModes or None
        In place of `by_lines`, where something is attached to a plate of many ports and known modes.
    """

    frequency: Real
    plate: LocalPlate
    state: PlateState
    modal: ModalForm | None
    by_lines: Complex | None = None
    seated: SeatedModes | None = None

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
            if modal is not None and frequency.size == 1 and not modal.count:
                return cls(frequency, plate, state, _modal(plate, state, _seats(plate, state)))
            if modal is not None and not modal.count and plate.composite.coupling.shape[1] >= LEAST_PORTS:
                seated = SeatedModes(modal, frequency, *_seats(plate, state))
                return cls(frequency, plate, state, None, seated=seated)
            return cls(frequency, plate, state, None, _attached(plate, state, frequency, modal))
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
        if self.seated is not None:
            ports = self.composite.coupling.T
            return np.stack([self.seated.field(port[:, None]) for port in ports], axis=1)
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
        if self.seated is not None:
            return self.seated.compliance(left, right)
        answers = self.answers[:, list(columns)]
        return np.asarray((left.T @ answers.reshape(len(left), -1)).reshape(-1, *answers.shape[1:]))

    def driven(self, drive: Complex) -> Complex:
        """Z**-1 b drive, (m, F), of amounts (P, F) at all ports."""
        if self.seated is not None:
            return self.seated.field(self.composite.coupling @ drive)
        return np.asarray(np.einsum("mpf,pf->mf", self.answers, drive))

    def felt(self, force: Complex | Real) -> Complex:
        """Return b' Z**-1 force, (P, F), of forces (m, F) in local coordinates, or (m, 1) at all lines."""
        if self.seated is not None:
            return self.seated.felt(self.composite.coupling, force)
        every = np.broadcast_to(force, (len(force), self.frequency.size))
        return np.asarray(np.einsum("mpf,mf->pf", self.answers, every))


def _attached(plate: LocalPlate, state: PlateState, frequency: Real, modal: ModalForm | None) -> Complex:
    """Z**-1 b of every port, (m, P, F), with a state's attachments, each of which changes Z by rank one.

    Z = Z0 + R' z R gives Z**-1 b = Z0**-1 b - Z0**-1 R' (1 + z R Z0**-1 R')**-1 z R Z0**-1 b (Woodbury), with the
    rows R of the deflection and the stiffness z, as felt, of the attachments.
    """
    local = plate.composite
    rows, z = _seats(plate, state)
    loads = np.hstack([local.coupling, rows.T])
    if modal is None:
        answers = solved_by_lines(replace(plate, composite=replace(local, coupling=loads)), state, frequency)
    else:
        answers = np.empty((*loads.shape, frequency.size), complex)
        for first in range(0, loads.shape[1], PORTS_AT_ONCE):
            some = slice(first, first + PORTS_AT_ONCE)
            answers[:, some] = modal.solve(loads[:, some], frequency).transpose(2, 0, 1)
    count = local.coupling.shape[1]
    felt = z[:, None] * np.einsum("km,mpf->kpf", rows, answers)
    system = np.moveaxis(felt[:, count:], -1, 0) + np.eye(len(rows))
    forces = np.linalg.solve(system, np.moveaxis(felt[:, :count], -1, 0))
    answers, there = answers[:, :count], answers[:, count:]
    for first in range(0, count, PORTS_AT_ONCE):
        some = slice(first, first + PORTS_AT_ONCE)
        answers[:, some] -= np.einsum("mkf,fkp->mpf", there, forces[..., some])
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
