"""Fit of E, nu, eta and gain to one sweep by Levenberg-Marquardt, inside the model's box: start of a joint fit."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.twin_model import TwinModel
from analysis.updating.normal_equations import LONGEST, NormalEquations, SweepData, moved, normal_equations

MAX_STEPS = 30
SETTLED = 25.0
"""Excess of chi2 over its minimum at which a fit that reaches the noise stops: five standard deviations, from
where a joint fit converges. Scaled up in proportion for a fit that leaves more than noise."""
NEAR = 0.25
"""Step, in half-power half-widths, above which the predicted excess is not used: far from the data, where
resonances do not overlap, the predicted decrease is small too."""


@dataclass(frozen=True)
class SweepFit:
    """Result of one sweep's fit: its last point; if settled, the minimum is one step away.

    Attributes
    ----------
    point : NormalEquations
    misfit_start : float
        Misfit at the start.
    settled : bool
        False if the fit ended on the model's box or did not converge: its next step is not reliable.
    """

    point: NormalEquations
    misfit_start: float
    settled: bool

    @property
    def material(self) -> NDArray[np.float64]:
        """E [Pa], nu and eta, (3,), inside the box: one step from `point` if settled, else at `point`."""
        return self.point.ahead if self.settled else self.point.material

    @property
    def log_gain(self) -> float:
        """Logarithm of the gain, at the same place."""
        return float(np.log(self.point.gain)) + (float(self.point.full_step[3]) if self.settled else 0.0)

    @property
    def misfit(self) -> float:
        """Misfit at the same place; predicted if settled."""
        return self.point.misfit_ahead if self.settled else self.point.misfit


def fit_sweep(model: TwinModel, data: SweepData, start: NDArray[np.float64]) -> SweepFit:
    """Fit E, nu, eta and gain of one sweep.

    Parameters
    ----------
    start : (3,) ndarray
        E [Pa], nu and eta; the gain starts at its best value there.
    """
    point = normal_equations(model, data, model.box.clip(start))
    misfit_start = point.misfit
    damping = 1e-3
    for _ in range(MAX_STEPS):
        if _settled(model, point):
            break
        # the initial damping costs nothing near a minimum and saves many steps far from one
        step = np.clip(point.step(damping), -LONGEST, LONGEST)
        material = model.box.clip(moved(point.material, step[:3]))
        trial = normal_equations(model, data, material, point.gain * float(np.exp(step[3])))
        if trial.chi2 <= point.chi2:
            fallen = point.chi2 - trial.chi2
            point, damping = trial, damping / 30.0
            if fallen < 1e-9 * point.chi2:  # stopped by a bound of the box
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
