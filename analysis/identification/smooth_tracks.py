"""Modes of all sweeps fitted together: frequency and damping of each a smooth function of temperature.

Where damping is high, one FRF cannot tell two modes from one between them; sweeps of less damping can. Of a pole's
log |lambda| and log damping ratio, one part is the sweep's and common to all modes (modulus and loss at that
temperature), another belongs to the mode and changes slowly, a third is scatter:

    x(t, j) = common(t) + curve_j(T) + scatter

The curve of log |lambda| is a polynomial, that of log damping ratio nearly a constant: what damps a homogeneous
plate damps all its modes alike. All three parts and the poles are found together, residues eliminated sweep by
sweep, by Gauss-Newton steps on the posterior; its Hessian gives the deviations, neighbours included.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.identification.lines import Lines
from analysis.identification.parameters import Bounds, to_poles
from analysis.identification.residual_terms import ResidualTerms
from analysis.identification.variable_projection import Projection, project

DEGREE = 3
"""Of the polynomial in temperature that belongs to one mode's log frequency."""

OWN_DAMPING = (0.02, 0.005)
"""Standard deviations of a mode's own log damping ratio about the common one: constant, and along temperature."""

SCATTER = (1e-4, 1e-3)
"""Of log |lambda| and log damping ratio about the curves: laws of real materials are no polynomials."""


@dataclass(frozen=True)
class Curves:
    """What sweeps and modes have of their own.

    Attributes
    ----------
    basis : (T, P) ndarray
        Polynomials in temperature.
    sweep : (T, 2) ndarray
        Common part of log |lambda| and log damping ratio.
    own : (J, P, 2) ndarray
        Coefficients of every mode's curves.
    """

    basis: NDArray[np.float64]
    sweep: NDArray[np.float64]
    own: NDArray[np.float64]

    @property
    def place(self) -> NDArray[np.float64]:
        """Log |lambda| and log damping ratio on the curves, (T, J, 2)."""
        return self.sweep[:, None, :] + np.einsum("tp,jpd->tjd", self.basis, self.own)
