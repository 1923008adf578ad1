"""A smaller model for the few materials of one campaign."""

from collections.abc import Sequence

import numpy as np
import scipy.linalg

from analysis.arrays import Real
from analysis.local_laws import LocalLaws
from simulation.reduction.composition import Coefficients, composed
from simulation.reduction.damped_modes import DampedModes
from simulation.reduction.dashpots import columns
from simulation.reduction.effect_operators import BENDING_DEGREE, EffectOperators
from simulation.reduction.energy_decomposition import leading
from simulation.state.extreme_states import extreme_states
from simulation.state.field_basis import field_basis
from simulation.state.plate_state import PlateState

LINES = 60
TAIL = 1.5e-3
AROUND = 1e-5
"""Tolerance of the motions around the sensor, as a share of their size.

It is small because, when the mesh moves, most changes of energies cancel: the effect of the sensor's offset on a
transfer is the small difference.
"""


def for_materials(ops: EffectOperators, materials: Sequence[LocalLaws], tail: float = TAIL) -> EffectOperators:
    """Operators on the leading directions of a plate's responses at some materials, in plain and extreme states.

    Proper orthogonal decomposition, as in `simulation.reduction.energy_decomposition`. Extreme states are used
    with the first and the last material only.

    Parameters
    ----------
    ops : EffectOperators
    materials : sequence of LocalLaws
        At least one.
    tail : float
        Largest share of the responses left out, in the energy norm; the error of transfers is its square.

    Returns
    -------
    EffectOperators
        Over fewer coordinates.
    """
    basis = field_basis(BENDING_DEGREE)
    states = [
        PlateState.baseline(basis.xi, basis.zeta, laws, laws.reference, np.array([500.0])) for laws in materials
    ]
    for laws in (materials[0], materials[-1])[: len(materials)]:
        for size in (-1.0, 1.0):
            states += extreme_states(basis.xi, basis.zeta, laws, ops.offset_range, size)
    middle = composed(ops, Coefficients.of(states[len(materials) // 2], ops.offset_range or 1.0))
    energy = middle.plate + middle.fixed + (0.6 * np.pi * ops.band[1]) ** 2 * middle.mass
    root = scipy.linalg.cholesky(energy, lower=True)
    gram = np.zeros_like(energy)
    for state in states:
        answers = root.T @ _answers(ops, state)
        gram += answers @ answers.T
    strength, vectors = leading(gram, tail * np.sqrt(np.trace(gram)))
    directions = scipy.linalg.solve_triangular(root.T, vectors, lower=False)
    around = ops.zone @ (directions * np.sqrt(strength))
    return ops.restricted(directions, leading(around @ around.T, AROUND * float(np.linalg.norm(around)))[1])


def _answers(ops: EffectOperators, state: PlateState) -> Real:
    """Real and imaginary parts of the responses to patches and point forces, each of mass norm 1, (r, k)."""
    whole = composed(ops, Coefficients.of(state, ops.offset_range or 1.0))
    squares, shapes = scipy.linalg.eigh(whole.plate + whole.fixed, whole.mass, check_finite=False)
    force = shapes.T @ np.hstack([whole.coupling, ops.forces])
    lines = np.linspace(*ops.band, LINES)
    dashpots = shapes.T @ columns(ops.damping, np.eye(ops.size))
    modal = DampedModes(squares, shapes, force, dashpots).modal(lines, 0.03)
    modal /= np.sqrt((np.abs(modal) ** 2).sum(axis=(0, 2), keepdims=True))
    flat = modal.reshape(len(squares), -1)
    return np.asarray(shapes @ np.hstack([flat.real, flat.imag]))
