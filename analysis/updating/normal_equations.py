"""Weighted misfit of one sweep at one material, its gradient and its Gauss-Newton curvature.

Fit of E, nu, eta and gain to one sweep by Levenberg-Marquardt, inside the model's box: start of a joint fit.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from analysis.checked_fields import check_finite, check_range, check_shapes
from analysis.material import LocalLaws
from analysis.recordings.frf import Frf
from analysis.recordings.sweep_point import SweepPoint
from analysis.twin_model import NO_EFFECTS, TwinModel


@dataclass(frozen=True)
class SweepData:
    """The lines of one sweep that take part in a fit.

    Attributes
    ----------
    frequency : (F,) ndarray
        Hz.
    h : (K, F) complex ndarray
        Measured FRF, V/V.
    weight : (K, F) ndarray
        1 / variance.
    temperature : float
        Degrees Celsius.
    source : int
        Index of the input that drove.
    """

    frequency: NDArray[np.float64]
    h: NDArray[np.complex128]
    weight: NDArray[np.float64]
    temperature: float = 20.0
    source: int = 0

    def __post_init__(self) -> None:
        check_shapes(self, frequency="F", h="K F", weight="K F")
        check_finite(self, "h", "weight", "temperature")
        check_range(self, 0.0, np.inf, "weight")

    @property
    def point(self) -> SweepPoint:
        """Circumstances of a sweep by itself: a steady temperature, 1 V."""
        return SweepPoint(self.temperature, 0.0, 1.0, self.source)

    def answer(self, model: TwinModel, material: ArrayLike) -> NDArray[np.complex128]:
        """Transfer (K, F) of a model with a material (E, nu, eta), at the sweep's lines and circumstances."""
        return model.frf(self.laws(material), self.frequency, NO_EFFECTS, self.point)

    def laws(self, material: ArrayLike) -> LocalLaws:
        """Laws through a material (E, nu, eta) at the sweep's temperature."""
        return LocalLaws.of_material(*map(float, np.asarray(material)), reference=self.temperature)

    @classmethod
    def of(cls, frf: Frf, sweep: int, stride: int = 1) -> "SweepData":
        """Take every `stride`-th line of one sweep that is not excluded.

        Parameters
        ----------
        sweep : int
            Its index in the FRFs.
        """
        lines = np.flatnonzero(~frf.excluded)[::stride]
        return cls(
            frf.frequency[lines],
            frf.h[sweep][:, lines],
            1.0 / frf.variance[sweep][:, lines],
            float(frf.temperature[sweep]),
            int(frf.driven_by[sweep]),
        )


LONGEST = 0.5
"""Largest step of any parameter for which the linearisation is used."""


@dataclass(frozen=True)
class NormalEquations:
    """Least squares of one sweep, linearised at a material and a gain.

    The four parameters are log E, nu, log eta and log gain.

    Attributes
    ----------
    material : (3,) ndarray
        E [Pa], nu, eta.
    gain : float
    chi2 : float
        2 sum |r|^2 / variance: real and imaginary parts each count one degree of freedom.
    dof : int
        Real data less the four parameters.
    misfit : float
        rms|r| / rms|h|, unweighted: the square root of the paper's eq. (12).
    matrix : (4, 4) ndarray
        J'J, whose inverse is the covariance.
    gradient : (4,) ndarray
        J'r.
    """

    material: NDArray[np.float64]
    gain: float
    chi2: float
    dof: int
    misfit: float
    matrix: NDArray[np.float64]
    gradient: NDArray[np.float64]

    def step(self, damping: float) -> NDArray[np.float64]:
        """Levenberg-Marquardt step, damped on the diagonal."""
        damped = self.matrix + damping * np.diag(np.diag(self.matrix))
        return np.linalg.solve(damped, self.gradient).astype(np.float64)

    def following(self, gain_step: float) -> NDArray[np.float64]:
        """Step of (log E, nu, log eta) to their best values once log gain has stepped by `gain_step`."""
        gradient = self.gradient[:3] - self.matrix[:3, 3] * gain_step
        step: NDArray[np.float64] = np.clip(np.linalg.solve(self.matrix[:3, :3], gradient), -LONGEST, LONGEST)
        return step

    @property
    def ahead(self) -> NDArray[np.float64]:
        """Material (E, nu, eta) after `full_step`."""
        return moved(self.material, self.full_step[:3])

    @property
    def full_step(self) -> NDArray[np.float64]:
        """Undamped step (4,), cut to `LONGEST`."""
        step: NDArray[np.float64] = np.clip(self.step(0.0), -LONGEST, LONGEST)
        return step

    @property
    def decrease(self) -> float:
        """Predicted decrease of chi2 by a full step."""
        return float(self.gradient @ self.step(0.0))

    @property
    def misfit_ahead(self) -> float:
        """Approximate misfit after a full step, assumed to fall like the weighted residual."""
        return self.misfit * float(np.sqrt(max(1.0 - self.decrease / self.chi2, 0.0)))

    @property
    def excess(self) -> float:
        """chi2 per degree of freedom after a full step, at least 1: factor on variances for model error."""
        return max((self.chi2 - self.decrease) / self.dof, 1.0)

    @property
    def remainder(self) -> float:
        """Approximate excess of chi2 after a full step if `widths` is below 1: `decrease` times its square."""
        return self.decrease * self.widths**2

    @property
    def widths(self) -> float:
        """Full step in half-power half-widths of a resonance.

        log f**2 changes as log E and about as nu, relative to eta; steps of log eta and log gain count unscaled.
        """
        step = np.abs(self.step(0.0))
        return float((step[0] + step[1]) / self.material[2] + step[2] + step[3])


def best_gain(transfer: NDArray[np.complex128], data: SweepData) -> tuple[float, float]:
    """Real, positive gain g minimising chi2 of h - g transfer, and that chi2.

    With a wrong material the transfer may be out of phase with h, and the best gain would be zero or negative: a
    twentieth of the ratio of their sizes is used instead, because with zero gain nothing else could be fitted.
    """
    power = float((data.weight * np.abs(transfer) ** 2).sum())
    size = float((data.weight * np.abs(data.h) ** 2).sum())
    gain = float((data.weight * (transfer.conj() * data.h).real).sum()) / power
    gain = max(gain, 0.05 * float(np.sqrt(size / power)))
    return gain, 2.0 * float((data.weight * np.abs(data.h - gain * transfer) ** 2).sum())


def moved(material: NDArray[np.float64], step: NDArray[np.float64]) -> NDArray[np.float64]:
    """Material (E, nu, eta) after a step in (log E, nu, log eta)."""
    return np.array([material[0] * np.exp(step[0]), material[1] + step[1], material[2] * np.exp(step[2])])


def normal_equations(
    model: TwinModel, data: SweepData, material: NDArray[np.float64], gain: float | None = None
) -> NormalEquations:
    """Linearise the fit of one sweep.

    Parameters
    ----------
    material : (3,) ndarray
        E [Pa], nu and eta.
    gain : float or None
        V/V; None for the best gain at `material`.

    Raises
    ------
    ValueError
        Outside the model's box.
    """
    line = model.linearise(data.laws(material), data.frequency, NO_EFFECTS, data.point)
    if gain is None:
        gain = best_gain(line.transfer, data)[0]
    predicted = gain * line.transfer
    jacobian = np.concatenate([gain * line.by_material, predicted[None]]).reshape(4, -1)
    residual = (data.h - predicted).ravel()
    weight = data.weight.ravel()
    weighted = 2.0 * weight * jacobian.conj()
    return NormalEquations(
        material=np.asarray(material, dtype=float),
        gain=gain,
        chi2=2.0 * float((weight * np.abs(residual) ** 2).sum()),
        dof=2 * residual.size - 4,
        misfit=float(np.linalg.norm(residual) / np.linalg.norm(data.h)),
        matrix=(weighted @ jacobian.T).real,
        gradient=(weighted @ residual).real,
    )


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
