"""E, nu, eta and gain of one sweep by Levenberg-Marquardt, inside the model's box: near enough for a joint fit."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.twin_model import TwinModel
from analysis.updating.normal_equations import LONGEST, NormalEquations, SweepData, moved, normal_equations

MAX_STEPS = 30
SETTLED = 25.0
"""Of chi2, what a step may leave of its own in a fit that reaches the noise: five standard deviations, from where
a joint fit converges. It is larger in proportion for a fit that leaves more than the noise."""
NEAR = 0.25
"""Step, in half-power half-widths, from which on nothing is said of what it leaves: far from the data, where
resonances do not overlap, the predicted decrease is small too."""


@dataclass(frozen=True)
class SweepFit:
    """Result of one sweep's fit: its last point, from which a settled fit is one step from the minimum.

    Attributes
    ----------
    point : NormalEquations
    misfit_start : float
        Where the fit began.
    settled : bool
        False where it ran into the model's box or did not converge: its next step is not to be trusted.
    """

    point: NormalEquations
    misfit_start: float
    settled: bool

    @property
    def material(self) -> NDArray[np.float64]:
        """E [Pa], nu and eta, (3,), inside the box: a step ahead of `point` if settled, else there."""
        return self.point.ahead if self.settled else self.point.material

    @property
    def log_gain(self) -> float:
        """Logarithm of the gain, likewise."""
        return float(np.log(self.point.gain)) + (float(self.point.full_step[3]) if self.settled else 0.0)

    @property
    def misfit(self) -> float:
        """Misfit, likewise; that ahead is predicted."""
        return self.point.misfit_ahead if self.settled else self.point.misfit


def fit_sweep(model: TwinModel, data: SweepData, start: NDArray[np.float64]) -> SweepFit:
    """Fit E, nu, eta and gain of one sweep.

    Parameters
    ----------
    model : TwinModel
    data : SweepData
    start : (3,) ndarray
        E [Pa], nu and eta; the gain starts at its best value there.

    Returns
    -------
    SweepFit
    """
    point = normal_equations(model, data, model.box.clip(start))
    misfit_start = point.misfit
    damping = 1e-3
    for _ in range(MAX_STEPS):
        if _settled(model, point):
            break
        # the start damping costs nothing near a minimum and saves a long way round far from one
        step = np.clip(point.step(damping), -LONGEST, LONGEST)
        material = model.box.clip(moved(point.material, step[:3]))
        trial = normal_equations(model, data, material, point.gain * float(np.exp(step[3])))
        if trial.chi2 <= point.chi2:
            fallen = point.chi2 - trial.chi2
            point, damping = trial, damping / 30.0
            if fallen < 1e-9 * point.chi2:  # leaning on the wall of the box
                break
        else:
            damping *= 20.0
            if damping > 1e8:
                break
    return SweepFit(point, misfit_start, _settled(model, point))


def _settled(model: TwinModel, point: NormalEquations) -> bool:
    """Whether one more step ends near the minimum, and within the box."""
    inside = bool(model.box.inside(point.ahead))
    return inside and point.widths < NEAR and point.remainder < SETTLED * point.excess
