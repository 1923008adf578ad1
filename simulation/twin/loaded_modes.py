"""Free vibration of a plate whose patches are connected to inputs: what an FRF measured there shows.

A voltage V on a patch acts on the plate as -b V, and its charge balance is y V = b'u with y = Cp + Cc + 1/(j w R).
So b b'/y is added to the stiffness for every connected patch: nothing at a short circuit, most for an open patch.

Likewise R z R' for whatever is attached at R, of dynamic stiffness z. Of a mass or a resonator z follows the
frequency: a mode is where the plate, with z of a frequency, vibrates freely at this frequency.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from analysis.arrays import Complex, Real
from simulation.reduction.modal_form import ModalForm
from simulation.twin.instruments import Instruments
from simulation.twin.local_solution import LocalSolution

MODE_FREQUENCIES = 8
"""Number of frequencies over the band at which modes are computed: y changes slowly, and each mode is interpolated
to its own frequency."""


@dataclass(frozen=True)
class LoadedModes:
    """Modes of a solved plate with its instruments.

    Attributes
    ----------
    poles : (m,) complex ndarray
        rad/s, upper half plane, by ascending magnitude.
    shapes : (m, m) complex ndarray
        In local coordinates, one a column.
    """

    poles: Complex
    shapes: Complex

    @classmethod
    def of(cls, solved: LocalSolution, modal: ModalForm, instruments: Instruments, capacitance: Real) -> Self:
        """Compute the modes.

        Parameters
        ----------
        solved : LocalSolution
            Over the band.
        modal : ModalForm
            Of `solved`, without dashpots.
        capacitance : (P,) ndarray, F
            Of all patches.

        Returns
        -------
        LoadedModes
        """
        nodes = np.geomspace(solved.frequency[0], solved.frequency[-1], MODE_FREQUENCIES)
        connected = list(instruments.connected)
        force = modal.inverse @ solved.composite.coupling[:, connected]
        motion = solved.composite.coupling[:, connected].T @ modal.shapes
        across = instruments.across(capacitance, nodes)
        forms = [ModalForm.of(np.diag(modal.poles) + (force / y) @ motion) for y in across.T]
        roots = np.array([_upper(form.poles) for form in forms])
        own = np.abs(roots).mean(axis=0) / (2 * np.pi)
        for _ in range(3):
            poles = np.array([np.interp(f, nodes, column) for f, column in zip(own, roots.T, strict=True)])
            own = np.abs(poles) / (2 * np.pi)
        nearest = np.abs(nodes[:, None] - own).argmin(axis=0)
        shapes = np.array([forms[n].shapes[:, j] for j, n in enumerate(nearest)]).T
        order = np.argsort(np.abs(poles))
        return cls(poles[order], (modal.shapes @ shapes)[:, order])


LINES_OF_ONE_WINDOW, NEAR_WINDOW = 40, 4.0
"""Lines at which the same modes of the plate are coupled by what acts: those within this factor of the lines. The
others follow it as they do at each line."""


def attached_poles(
    solved: LocalSolution, modal: ModalForm, instruments: Instruments, capacitance: Real
) -> Complex:
    """Poles of a plate with its instruments and what is attached to it.

    The n-th root of the plate at a line passes the line's frequency from above where a mode is; from below it does
    where the stiffness of a resonator turns over. The motion of a resonator that hardly moves the plate is no mode
    of it.

    Parameters
    ----------
    solved : LocalSolution
        Over lines so close that the stiffness of what is attached changes evenly from one to the next.
    modal : ModalForm
        Of `solved`.
    capacitance : (P,) ndarray, F
        Of all patches.

    Returns
    -------
    (n,) complex ndarray
        rad/s, upper half plane, by ascending magnitude, within the lines.
    """
    lines, connected = solved.frequency, list(instruments.connected)
    columns = np.hstack([solved.composite.coupling[:, connected], modal.columns])
    force, motion = modal.inverse @ columns, columns.T @ modal.shapes
    z = np.vstack([1.0 / instruments.across(capacitance, lines), modal.acting(lines)]).T
    own = np.abs(np.sqrt(modal.poles)) / (2 * np.pi)
    found = []
    for start in range(0, lines.size - 1, LINES_OF_ONE_WINDOW):
        some = slice(start, start + LINES_OF_ONE_WINDOW + 1)
        here, acting = lines[some], z[some]
        near = (own > here[0] / NEAR_WINDOW) & (own < here[-1] * NEAR_WINDOW)
        terms = 1.0 / (modal.poles[~near] - (2 * np.pi * here[:, None]) ** 2)
        beyond = (motion[:, ~near] * terms[:, None]) @ force[~near]
        felt = np.linalg.solve(np.eye(len(columns.T)) + acting[:, :, None] * beyond, _diagonal(acting))
        matrix = np.diag(modal.poles[near]) + force[near] @ felt @ motion[:, near]
        roots = _upper(np.linalg.eigvals(matrix))
        roots = np.take_along_axis(roots, np.argsort(np.abs(roots), axis=1), axis=1)
        above = np.abs(roots) / (2 * np.pi) - here[:, None]
        line, n = np.nonzero((above[:-1] > 0.0) & (above[1:] <= 0.0))
        share = above[line, n] / (above[line, n] - above[line + 1, n])
        found.append(roots[line, n] + share * (roots[line + 1, n] - roots[line, n]))
    poles = np.concatenate(found)
    return np.asarray(poles[np.argsort(np.abs(poles))])


def _diagonal(values: Complex) -> Complex:
    """Diagonal matrices (F, q, q) of values (F, q)."""
    return np.asarray(values[:, :, None] * np.eye(values.shape[1]))


def _upper(squares: Complex) -> Complex:
    """Poles in the upper half plane, rad/s, of complex squared angular frequencies."""
    roots = 1j * np.sqrt(squares)
    return np.asarray(-np.abs(roots.real) + 1j * np.abs(roots.imag))
