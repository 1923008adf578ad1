"""A plate of known modes with attachments, between many ports: what acts is asked for, not all responses at once.

Each attachment changes Z by rank one. With the modes of Z0, the rows R of the deflection at the attachments and
their stiffness z as felt (Woodbury),

    b' Z**-1 f = b' Z0**-1 f - b' Z0**-1 R' (1 + z R Z0**-1 R')**-1 z R Z0**-1 f

for any force f. The responses Z**-1 b of a scan's hundreds of ports are never formed: of 200 ports, in 150
coordinates and at 1080 lines, they are 0.5 GB and took most of the time of a derivative.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from analysis.arrays import Complex, Real
from simulation.reduction.modal_form import ModalForm

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
