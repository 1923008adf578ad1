"""Self-consistent strain energy, line by line, of a plate whose state depends on it.

At every line e = g(e), where g(e) is the energy of the plate in the state for the relative energy e. At high
levels there may be three solutions, as beside every resonance that bends over. The one computed is the lowest,
which is reached by raising the level from zero. It is bracketed by steps that are short compared with the width of
a resonance, then found by the method of Anderson and Bjoerck (BIT 13, 1973).
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real, Whole
from simulation.reduction.composition import COMPLEX_STEP
from simulation.state.plate_state import SPECTRA, PlateState
from simulation.twin.local_plate import LocalPlate
from simulation.twin.local_solution import LineSolver

StateOf = Callable[[NDArray[Any]], PlateState]
"""State of the plate for given relative strain energies (F,); only its spectra may depend on them."""

LONGEST_STEP = 0.5
"""Longest step towards the solution, over the change of e that shifts a resonance by its half-power width."""
MOST_STEPS = 200
"""Steps by which a bracket is sought; each may be twice as long as the one before, up to `LONGEST_STEP`."""
MOST_SECANTS = 80
"""Bound of the regula falsi with reduced weights, which converges faster than linearly."""
SETTLED_ENERGY = 1e-12
"""Tolerance of e - g(e), over 1 + e."""


@dataclass(frozen=True)
class StrainEnergy:
    """Relative strain energy g(e), amplitude squared taken, of the plate alone with its patches short-circuited.

    Attributes
    ----------
    solver : LineSolver
    drive : (m,) complex ndarray
        Coupling of the actuator, in the solver's modes.
    metric : (m, m) complex ndarray
        x^H metric x is u^H K u.
    state_of : callable
    scale : float
        Energies per J/V2.
    density : float
        Mass of the plate by area, kg/m2.
    """

    solver: LineSolver
    drive: Complex
    metric: Complex
    state_of: StateOf
    scale: float
    density: float

    @classmethod
    def of(
        cls,
        plate: LocalPlate,
        actuator: int,
        state_of: StateOf,
        frequency: Real,
        *,
        scale: float = 1.0,
        density: float = 1.0,
    ) -> Self:
        """Prepare in local coordinates, which do not depend on the energy.

        Parameters
        ----------
        actuator : int
            Port of the patch that is driven.
        state_of : callable
            From the relative strain energy (F,) to the state.
        frequency : (F,) ndarray, Hz
        scale : float
            Energies per J/V2.
        density : float
            Mass of the plate by area, kg/m2.

        Returns
        -------
        StrainEnergy
        """
        solver = LineSolver.of(plate, state_of(np.zeros(frequency.size)), frequency)
        shapes = solver.modes.shapes
        metric = shapes.conj().T @ (plate.composite.plate @ shapes)
        return cls(solver, solver.into(plate.composite.coupling[:, actuator]), metric, state_of, scale, density)

    def at(self, energy: Real, lines: Whole | None = None) -> Real:
        """Return g at some lines (n,), all if None, when the energies of all lines are `energy` (F,)."""
        lines = np.arange(energy.size) if lines is None else lines
        state = self.state_of(energy)
        right = np.broadcast_to(self.drive[:, None], (self.drive.size, lines.size))
        x = self.solver.solve(self.solver.weights(state), right, lines)
        stored = 0.5 * np.einsum("mf,mf->f", x.conj(), self.metric @ x).real
        return np.asarray(self.scale * state.storage[lines] * stored)

    def settled(self) -> Real:
        """Return the lowest e = g(e) of every line, (F,); ValueError where there is none within reach."""
        low = np.zeros(self.solver.omega2.size)
        linear = self.at(low)
        if not self._follows(linear):
            return linear
        high, below, above = low.copy(), -linear, np.zeros(low.size)
        ahead = np.arange(low.size)
        for k in range(MOST_STEPS):
            # steps do not skip a resonance that bends over; where e changes little, the bracket is narrow
            step = np.minimum(self._short(low)[ahead], -below[ahead] * 2.0 ** (k + 1))
            probe = low.copy()
            probe[ahead] += step
            beyond = probe[ahead] - self.at(probe, ahead)
            over = beyond >= 0.0
            high[ahead[over]], above[ahead[over]] = probe[ahead[over]], beyond[over]
            low[ahead[~over]], below[ahead[~over]] = probe[ahead[~over]], beyond[~over]
            ahead = ahead[~over]
            if not ahead.size:
                return self._between(low, high, below, above)
        raise ValueError(
            f"the strain energy at {np.sqrt(self.solver.omega2[ahead[0]]) / (2 * np.pi):.6g} Hz finds no value "
            f"that its own effects allow, up to {low[ahead[0]]:.3g}: weaken the effects that follow it"
        )

    def _follows(self, linear: Real) -> bool:
        """Whether the state at the linear energies differs from that at zero energy."""
        here, there = self.state_of(np.zeros(linear.size)), self.state_of(linear)
        return any((getattr(here, name) != getattr(there, name)).any() for name in SPECTRA)

    def _short(self, energy: Real) -> Real:
        """Return the longest step that cannot miss a resonance, (F,)."""
        state = self.state_of(energy + 1j * COMPLEX_STEP)
        pull = [np.abs(np.imag(getattr(state, name))) / COMPLEX_STEP for name in SPECTRA]
        omega2 = self.solver.omega2
        eta = float(np.real(state.laws.loss_factor(state.mean_temperature)))
        moved = pull[0] + eta * pull[1] + pull[2] / self.density + pull[3] / (np.sqrt(omega2) * self.density)
        with np.errstate(divide="ignore"):
            return np.asarray(LONGEST_STEP * eta * np.real(state.loss) / moved)

    def _between(self, low: Real, high: Real, below: Real, above: Real) -> Real:
        """Return the solutions between energies with e - g(e) below and above zero."""
        found, left = high.copy(), np.flatnonzero(above > 0.0)
        a, fa, b, fb = (values.copy() for values in (low, below, high, above))
        for _ in range(MOST_SECANTS):
            if not left.size:
                return found
            found[left] = b[left] - fb[left] * (b[left] - a[left]) / (fb[left] - fa[left])
            f = found[left] - self.at(found, left)
            # b is the newest point; a is on the other side, its weight reduced if it is kept twice
            same = np.sign(f) == np.sign(fb[left])
            less = 1.0 - f / fb[left]
            less = np.where(less > 0.0, less, 0.5)
            a[left], fa[left] = np.where(same, a[left], b[left]), np.where(same, fa[left] * less, fb[left])
            b[left], fb[left] = found[left], f
            settled = (np.abs(f) <= SETTLED_ENERGY * (1.0 + found[left])) | (a[left] == b[left])
            left = left[~settled]
        return found
