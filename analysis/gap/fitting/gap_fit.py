"""Result of a fit of laws, readings, gain and effects."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.gap.fitting.state import FreeParameters, GapState


@dataclass(frozen=True)
class GapFit:
    """Result of a fit.

    Attributes
    ----------
    state : GapState
    free : FreeParameters
        The effects' parameters that were fitted.
    covariance : (P, P) ndarray
        Posterior covariance of the free parameters, everything else eliminated, of the noise.
    information : (P, P) ndarray
        Its inverse without the prior.
    chi2 : (T, K) ndarray
        Of the nodes.
    readings : (T,) ndarray
        chi2 of the temperature readings, which are data too: a thermal lag shows only there.
    tilts : (G,) ndarray
        chi2 of the laws' slopes against those estimated from neighbouring temperatures.
    dof : float
        Number of real data less fitted unknowns.
    prior : float
        Minus twice the log prior of the parameters, up to a constant.
    residual, predicted : (T, K, n) complex ndarray
        Whitened residual, and the model's spline coefficients [V/V].
    sigma_log_gain : (I,) ndarray
        Standard deviation of every input's log gain at fixed parameters, of the noise; 0 where it was held.
    law_sigma : (G, 3) ndarray
        Standard deviations of log E, nu and log eta of the groups, gains and effects eliminated, of the noise.
    alone : (T, 4, 4) ndarray
        Information matrix of each sweep alone, for its log E, nu, log eta and log gain.
    settled : bool
    on_wall : tuple of (effect, parameter)
        Parameters at a bound of their range.
    passes : int
        Number of linearisations of all sweeps.
    """

    state: GapState
    free: FreeParameters
    covariance: Real
    information: Real
    chi2: Real
    readings: Real
    tilts: Real
    dof: float
    prior: float
    residual: NDArray[np.complex128] = field(repr=False)
    predicted: NDArray[np.complex128] = field(repr=False)
    sigma_log_gain: Real
    law_sigma: Real
    alone: Real
    settled: bool
    on_wall: tuple[tuple[str, str], ...]
    passes: int

    @property
    def total(self) -> float:
        """chi2 over all sweeps, channels, readings and slopes."""
        return float(self.chi2.sum() + self.readings.sum() + self.tilts.sum())

    def spread(self, overstated: float) -> float:
        """Return the factor on all standard deviations for what is left beyond noise and for the twin's own error.

        `overstated` is that of `analysis.gap.data.sweeps.GapSweeps`. The twin's error is common to all lines, and
        changes laws and gains as well as the effects' parameters.
        """
        return float(np.sqrt(max(self.total / self.dof, 1.0) * overstated))

    @property
    def log_evidence(self) -> float:
        """Laplace's approximation, up to a constant common to all sets of effects on the same sweeps."""
        scaled = np.eye(len(self.covariance)) + self.free.sigma[:, None] ** 2 * self.information
        occam = float(np.linalg.slogdet(scaled)[1]) if len(self.covariance) else 0.0
        return -0.5 * (self.total + self.prior + occam)

    @property
    def sigma(self) -> Real:
        """Standard deviations of the free parameters, (P,)."""
        return np.sqrt(np.diag(self.covariance))
