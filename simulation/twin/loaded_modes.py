"""Free vibration of a plate whose patches are connected to inputs: what an FRF measured there shows.

A voltage V on a patch acts on the plate as -b V, and its charge balance is y V = b'u with y = Cp + Cc + 1/(j w R).
So b b'/y is added to the stiffness for every connected patch: nothing at a short circuit, most for an open patch.
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


def _upper(squares: Complex) -> Complex:
    """Poles in the upper half plane, rad/s, of complex squared angular frequencies."""
    roots = 1j * np.sqrt(squares)
    return np.asarray(-np.abs(roots.real) + 1j * np.abs(roots.imag))
