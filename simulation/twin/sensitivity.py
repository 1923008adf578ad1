"""Derivatives of weighted sums of a plate's responses: a field and its adjoint serve all parameters.

With the compliance G = b' Z**-1 b between patches and weights l and r on them, a change dZ, db alters l' G r by
-y' dZ u + y' db r + l' db' u: the field u = Z**-1 b r that r drives, and y = Z**-1 b l that l would drive.

Of a strain energy on which the state depends, by the theorem of implicit functions.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real
from simulation.reduction.composition import COMPLEX_STEP, Composite, proportion
from simulation.reduction.modal_form import ModalSlopes
from simulation.state.attached import Seat
from simulation.state.plate_state import PlateState, PointLoad
from simulation.twin.instruments import Transfer
from simulation.twin.local_plate import deflection_at
from simulation.twin.local_solution import LineSolver, LocalSolution

ParameterChange = tuple[Composite, PlateState]
"""What a parameter changes: the derivative of the composite, in local coordinates, and the state with an imaginary
step of the parameter."""

AT_ONCE = 1_000_000
"""Derivatives of compliances that are held at once, about; with their copies each takes 100 bytes."""


@dataclass(frozen=True)
class TransferSensitivity:
    """Change of sense' G drive, at every frequency.

    Attributes
    ----------
    solved : LocalSolution
    state : PlateState
        Whose solution it is.
    drive : (P, F) complex ndarray
        Volts on the patches, and minus the forces on further ports.
    sense : (K, P, F) complex ndarray
        Weights of each patch's charge, and of each further port's deflection, in each of K sums.
    field : (m, F) complex ndarray
        Z**-1 b drive.
    adjoint : (K, m, F) complex ndarray or None
        Of sums over the whole field; None where they are those of the ports in `sense`.
    """

    solved: LocalSolution
    state: PlateState
    drive: Complex
    sense: Complex
    field: Complex
    adjoint: Complex | None = None

    @classmethod
    def of(cls, solved: LocalSolution, state: PlateState, drive: Complex, sense: Complex) -> Self:
        """Compute the field from the ports' responses.

        Parameters
        ----------
        state : PlateState
            Whose solution it is.
        drive : (P, F) complex ndarray
            Volts on the patches, and minus the forces on further ports.
        sense : (K, P, F) complex ndarray
            Weights of the charge of each patch, and of the deflection of each further port.

        Returns
        -------
        TransferSensitivity
        """
        return cls(solved, state, drive, sense, solved.driven(drive))

    def by_each(self, steps: Sequence[ParameterChange]) -> Iterator[Complex]:
        """Differentiate by each of some parameters as `by`, many at once."""
        size = max(1, AT_ONCE // self.field.size)
        for first in range(0, len(steps), size):
            forces, direct = zip(*(self._change(*one) for one in steps[first : first + size]), strict=True)
            yield from self._heard(np.array(forces)) + np.array(direct)

    def by(self, local: Composite, stepped: PlateState) -> Complex:
        """Differentiate by the parameter whose imaginary step turned `state` into `stepped`, (K, F).

        `local` is the derivative of the composite, in local coordinates.
        """
        return next(self.by_each([(local, stepped)]))

    def _change(self, local: Composite, stepped: PlateState) -> tuple[Complex, Complex]:
        """Force -dZ u + db r, (m, F), and what the sums change where the field stays, (K, F)."""
        force = np.zeros_like(self.field)
        for matrix, weight in impedance_change(self.solved, self.state, local, stepped):
            force -= weight * (matrix @ self.field.view(float)).view(complex)
        for left, right, weight in point_changes(self.solved, self.state, stepped):
            force -= left[:, None] * (weight * (right @ self.field))
        direct = np.zeros((len(self.sense), self.solved.frequency.size), complex)
        if local.coupling.any():  # of the patches, which are the first ports
            drive, sense = (part[..., : local.coupling.shape[1], :] for part in (self.drive, self.sense))
            force += local.coupling @ drive
            direct += np.einsum("kpf,mp,mf->kf", sense, local.coupling, self.field, optimize=True)
        return force, direct

    def _heard(self, forces: Complex) -> Complex:
        """Return what forces (D, m, F) change in each sum, (D, K, F): y' force, with the adjoint y = Z**-1 b l.

        Ports first: of a scan's hundreds of sums each weighs one, and their adjoint fields would fill the memory.
        """
        if self.adjoint is not None:
            return np.asarray(np.einsum("kmf,dmf->dkf", self.adjoint, forces))
        ports = self.solved.felt(forces)
        return np.stack(
            [(weights[p] * ports[:, p]).sum(axis=1) for weights, p in zip(self.sense, self.felt, strict=True)], 1
        )

    @cached_property
    def felt(self) -> list[NDArray[np.intp]]:
        """Ports that each sum weighs."""
        return [np.flatnonzero(weights.any(axis=-1)) for weights in self.sense]


@dataclass(frozen=True)
class ModalSensitivity:
    """Change of a transfer whose solution is a sum over modes: faster than fields for many lines.

    Attributes
    ----------
    solved : LocalSolution
    state : PlateState
        Whose solution it is.
    transfer : Transfer
        Of it.
    slopes : ModalSlopes
        Between output ports and driving ports.
    """

    solved: LocalSolution
    state: PlateState
    transfer: Transfer
    slopes: ModalSlopes

    def by_each(self, steps: Sequence[ParameterChange]) -> Iterator[Complex]:
        """Differentiate by each of some parameters as `TransferSensitivity.by`, many at once."""
        size = max(1, AT_ONCE // self.slopes.whole.size)
        for first in range(0, len(steps), size):
            yield from self._together(steps[first : first + size])

    def _together(self, steps: Sequence[ParameterChange]) -> Complex:
        """Return the derivatives (D, K, F) by D parameters."""
        ports = self.solved.composite.coupling
        seen, driving = list(self.transfer.instruments.seen), list(self.transfer.instruments.driving)
        slopes = np.zeros((len(steps), *self.slopes.whole.shape), complex)
        changes = [
            (place, matrix, weight)
            for place, (local, stepped) in enumerate(steps)
            for matrix, weight in impedance_change(self.solved, self.state, local, stepped)
        ]
        if changes:
            by_stiffness = self.slopes.by_stiffness(np.array([matrix for _, matrix, _ in changes]))
            for (place, _, weight), change in zip(changes, by_stiffness, strict=True):
                slopes[place] += weight * change
        coupled = [place for place, (local, _) in enumerate(steps) if local.coupling.any()]
        if coupled:
            moved = np.zeros((len(coupled), *ports.shape))
            for row, place in zip(moved, coupled, strict=True):
                coupling = steps[place][0].coupling
                row[:, : coupling.shape[1]] = coupling  # of the patches, which are the first ports
            slopes[coupled] += self.slopes.by_columns(moved[..., seen], moved[..., driving])
        total = self.slopes.connected(slopes)
        points = [
            (place, *change)
            for place, (_, stepped) in enumerate(steps)
            for change in point_changes(self.solved, self.state, stepped)
        ]
        if points:
            # a mass, a spring and a dashpot are tried at the same places: each place is asked for once
            rows = {row.tobytes(): row for _, left, right, _ in points for row in (left, right)}
            there = {key: number for number, key in enumerate(rows)}
            form, lines, sums = self.slopes.form, self.solved.frequency, self.slopes.sums
            loads = np.array(list(rows.values())).T
            heard = form.compliance(ports[:, seen], loads, lines, sums)
            moved_there = form.compliance(loads, ports[:, driving], lines, sums)
            for place, left, right, weight in points:
                total[place] -= (
                    weight * heard[:, there[left.tobytes()], None] * moved_there[None, there[right.tobytes()]]
                )
        return self.transfer.change(total)


def impedance_change(
    solved: LocalSolution, state: PlateState, local: Composite, stepped: PlateState
) -> list[tuple[Real, NDArray[Any]]]:
    """Differentiate Z by a parameter.

    Parameters
    ----------
    state : PlateState
        Whose solution it is.
    local : Composite
        Derivative of the composite, in local coordinates.
    stepped : PlateState
        The state with the parameter's imaginary step.

    Returns
    -------
    list of ((m, m) ndarray, (F,) ndarray)
        Matrices, each with its weight at every line; vanishing ones are left out.
    """
    omega = 2 * np.pi * solved.frequency
    rates = {name: _rate(getattr(stepped, name)) for name in ("storage", "loss", "area_mass", "area_resistance")}
    ratio = proportion(local.plate_loss, local.plate)
    weighed: list[tuple[Real, NDArray[Any]]] = [
        (local.plate, state.storage + 1j * state.loss * (ratio or 0.0)),
        (local.plate_loss, 1j * state.loss * (ratio is None)),
        (local.fixed, np.ones(omega.size)),
        (local.mass, -(omega**2)),
        (solved.composite.plate, rates["storage"]),
        (solved.composite.plate_loss, 1j * rates["loss"]),
        (
            solved.normal,
            _rate(stepped.area_stiffness) + 1j * omega * rates["area_resistance"] - omega**2 * rates["area_mass"],
        ),
    ]
    return [(matrix, weight) for matrix, weight in weighed if weight.any() and matrix.any()]


def point_changes(
    solved: LocalSolution, state: PlateState, stepped: PlateState
) -> list[tuple[Real, Real, NDArray[Any]]]:
    """Differentiate by a parameter what loads at points and attachments add to Z.

    Parameters
    ----------
    state : PlateState
        Whose solution it is.
    stepped : PlateState
        The state with the parameter's imaginary step.

    Returns
    -------
    list of ((m,) ndarray, (m,) ndarray, (F,) ndarray)
        Two vectors, whose outer product is the matrix, and its weight at every line.
    """
    found = []
    for row, rate, moved, acting in (*_loads(solved, state, stepped), *_seats(solved, state, stepped)):
        if rate.any():
            found.append((row, row, rate))
        if moved is not None and moved.any() and np.any(acting):
            found += [(moved, row, acting), (row, moved, acting)]
    return found


@dataclass(frozen=True)
class EnergySlopes:
    """Derivatives of the self-consistent strain energy by any parameter of a state (implicit function theorem).

    Attributes
    ----------
    sensitivity : TransferSensitivity
        Of the single sum (K u)^H du, with the motion u per volt on the actuator.
    stored : (F,) ndarray
        u^H K u / 2.
    scale : float
    feedback : (F,) ndarray
        dg/de.
    """

    sensitivity: TransferSensitivity
    stored: Real
    scale: float
    feedback: Real

    @classmethod
    def of(
        cls, solved: LocalSolution, actuator: int, state: PlateState, stepped: PlateState, scale: float
    ) -> Self:
        """Prepare derivatives at the self-consistent energy.

        Parameters
        ----------
        solved : LocalSolution
            At the self-consistent energy.
        actuator : int
            Port of the patch that is driven.
        state : PlateState
            At the self-consistent energy.
        stepped : PlateState
            The state with the energy e stepped by j `COMPLEX_STEP`.
        scale : float
            Energies per J/V2.

        Returns
        -------
        EnergySlopes
        """
        u = np.ascontiguousarray(solved.answers[:, actuator])
        force = solved.composite.plate @ u
        solver = LineSolver.of(solved.plate, state, solved.frequency)
        lines = np.arange(solved.frequency.size)
        adjoint = solver.back(solver.solve(solver.weights(state), solver.into(force.conj()), lines))
        drive = np.zeros(solved.answers.shape[1:], complex)
        drive[actuator] = 1.0
        sensitivity = TransferSensitivity(
            solved, state, drive, np.zeros((1, *drive.shape), complex), u, adjoint[None]
        )
        stored = 0.5 * np.einsum("mf,mf->f", u.conj(), force).real
        slopes = cls(sensitivity, stored, scale, np.zeros(stored.size))
        nothing = np.zeros_like(solved.normal)
        still = Composite(nothing, nothing, nothing, nothing, np.zeros_like(solved.composite.coupling))
        return cls(sensitivity, stored, scale, slopes.by(still, stepped))

    def by(self, local: Composite, stepped: PlateState) -> Real:
        """Differentiate e, (F,), by the parameter whose imaginary step gave `stepped` at the same e.

        `local` is as in `TransferSensitivity.by`.
        """
        u, storage = self.sensitivity.field, self.sensitivity.state.storage
        change = self.sensitivity.by(local, stepped)[0].real
        if local.plate.any():
            change = change + 0.5 * np.einsum("mf,mf->f", u.conj(), local.plate @ u).real
        direct = np.imag(stepped.storage) / COMPLEX_STEP * self.stored + storage * change
        return np.asarray(self.scale * direct / (1.0 - self.feedback))


Point = tuple[Real, NDArray[Any], Real | None, Any]
"""Row of the deflection, rate of the stiffness, rate of the row, and stiffness."""


def _loads(solved: LocalSolution, state: PlateState, stepped: PlateState) -> Iterator[Point]:
    omega = 2 * np.pi * solved.frequency
    loads = zip(state.point_loads, stepped.point_loads, strict=False)
    added = ((PointLoad(load.point), load) for load in stepped.point_loads[len(state.point_loads) :])
    for load, step in (*loads, *added):
        row = deflection_at(solved.operators, load, state) @ solved.basis
        rate = _rate(step.stiffness) + 1j * omega * _rate(step.damping) - omega**2 * _rate(step.mass)
        moved = None
        if stepped.departures.stepped:
            moved = deflection_at(solved.operators, load, stepped, stepped=True) @ solved.basis
        yield row, rate, moved, load.stiffness + 1j * omega * load.damping - omega**2 * load.mass


def _seats(solved: LocalSolution, state: PlateState, stepped: PlateState) -> Iterator[Point]:
    for one in stepped.attached:
        seat = Seat.of(solved.operators, one, stepped)
        rate = _rate(seat.stiffness) + 1j * _rate(seat.loss)
        moved = _rate(seat.row) @ solved.basis if np.iscomplexobj(seat.row) else None
        yield np.real(seat.row) @ solved.basis, rate, moved, np.real(seat.stiffness) + 1j * np.real(seat.loss)


def _rate(value: object) -> Real:
    return np.asarray(np.imag(value) / COMPLEX_STEP)  # type: ignore[call-overload]
