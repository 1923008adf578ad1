"""Natural modes of a reduced plate, with the damping of plate and supports."""

import numpy as np
import scipy.linalg

from analysis.arrays import Complex, Real
from simulation.reduction.reduced_model import ReducedModel


def lowest_modes(
    model: ReducedModel, youngs_modulus: float, poisson_ratio: float, loss_factor: float, count: int
) -> tuple[Complex, Real]:
    """Lowest undamped modes, with the damping of each by plate and dashpots (patches are lossless).

    Parameters
    ----------
    youngs_modulus : float
        Pa.
    count : int
        r at most.

    Returns
    -------
    squares : (count,) complex ndarray, rad2/s2
        Squared angular frequencies, with the damping as imaginary part.
    shapes : (r, count) ndarray

    Raises
    ------
    ValueError
        Outside the trained box.
    """
    model.require(youngs_modulus, poisson_ratio, loss_factor)
    stiffness = model.stiffness(youngs_modulus, poisson_ratio, loss_factor)
    values, shapes = scipy.linalg.eigh(stiffness.real, subset_by_index=(0, min(count, model.size) - 1))
    lost = np.einsum("rm,rs,sm->m", shapes, stiffness.imag, shapes)
    viscous = np.sqrt(np.abs(values)) * ((model.dashpots.T @ shapes) ** 2).sum(axis=0)
    return values + 1j * (lost + viscous), shapes
