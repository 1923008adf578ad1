"""A candidate fitted with its place, by a twin that has it.

The search over all candidates is linear, about the healthy panel, at places some centimetres apart. A spot that
has lost a fifth of its stiffness is neither small nor at one of these places: amplitude and place are fitted by
Gauss and Newton, the twin linearised anew about each estimate with the effect on.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from analysis.arrays import Real
from analysis.checked_fields import check_finite, check_shapes
from analysis.effect_card import Parameter, Values
from analysis.health.baseline import HealthBaseline
from analysis.health.candidates import ChangeCandidate
from analysis.health.recording import DateEquations, WhiteRecording, date_equations

MOST_STEPS = 8
"""Of Gauss and Newton: from a place within its neighbours' distance four are usual."""
STEPS_NEARER = 3
"""Of a fit that only says where another begins."""
STEPS_BEFORE_ABANDONING, ABANDONED_CHI2_RATIO = 3, 4.0
"""Steps after which a candidate is given up whose chi2 is so many times that of another."""
STEPS_BEFORE_JUDGING, PROMISED_TIMES, HOPELESS_EVIDENCE = 2, 4.0, 30.0
"""A fit is given up, too, that would stay this many nats behind another if all further steps together lowered chi2
by four times what the next one promises: 1e-13 of a probability."""
HALVINGS = 4
"""Of a step that does not lower chi2, or leads off the plate."""
LARGEST_MOVE = 0.015
"""m in one step: a place is not linear over more than an eighth of a bending wave."""
WARMEST_STEP = 4.0
"""K in one step: responses are not linear in the temperature beyond."""
TWIN_SHARE = 0.02
"""Share of an amplitude that the twin, whose mass and stiffness are known to a per cent or two, leaves open."""
SETTLED_STEP = 0.05
"""Largest step, in standard deviations, at which the fit ends."""


@dataclass(frozen=True)
class RefinedChange:
    """A candidate fitted to some dates.

    Attributes
    ----------
    candidate : ChangeCandidate
    values : mapping of str to float
        All parameters of the effect, SI.
    sigma : mapping of str to float
        Standard deviations of those that were fitted, by noise and by what the baseline cannot tell.
    evidence : float
        Log evidence over a healthy panel, nats.
    misfit : float
        Chi2 per degree of freedom that is left.
    """

    candidate: ChangeCandidate
    values: Values
    sigma: Values
    evidence: float
    misfit: float

    def __post_init__(self) -> None:
        check_finite(self, "evidence", "misfit")


@dataclass(frozen=True)
class _Fit:
    """Equations of all dates at one estimate."""

    point: Real
    matrix: Real
    gradient: Real
    chi2: float
    dof: int
    here: Real
    temperatures: Real
    by_change: Real
    before: float

    def __post_init__(self) -> None:
        check_shapes(self, point="P", matrix="P P", gradient="P", here="R", temperatures="R", by_change="R P")

    @property
    def noise(self) -> float:
        """Chi2 per degree of freedom to be expected next: no less than a quarter of the last one."""
        return max(self.chi2 / self.dof, 0.25 * self.before, 1.0)

    def temperatures_after(self, step: Real) -> Real:
        """Temperatures (R,) of the recordings after a step (P,) of the parameters."""
        moved = self.temperatures + self.by_change @ step - self.here
        return np.asarray(self.here + np.clip(moved, -WARMEST_STEP, WARMEST_STEP))


@dataclass(frozen=True)
class ChangeFit:
    """The dates to which candidates are fitted.

    Attributes
    ----------
    baseline : HealthBaseline
    recordings : tuple of WhiteRecording
    temperatures : tuple of float
        Of each, from which a fit begins, degrees Celsius.
    healthy : (float, int)
        Chi2 without a change, and its degrees of freedom.
    noise : float
        Chi2 per degree of freedom of the healthy panel: one for all candidates, so that their evidences compare.
    """

    baseline: HealthBaseline = field(repr=False)
    recordings: tuple[WhiteRecording, ...] = field(repr=False)
    temperatures: tuple[float, ...]
    healthy: tuple[float, int]
    noise: float

    def refined(
        self, candidate: ChangeCandidate, amplitude: float, variance: float, rival: float
    ) -> RefinedChange:
        """Fit a candidate of the library.

        Parameters
        ----------
        candidate : ChangeCandidate
            At the place where the fit begins.
        amplitude : float
            At which it begins, SI.
        variance : float
            Of the amplitude, by what the baseline cannot tell.
        rival : float
            Chi2 of the best candidate so far: one that stays far behind is not fitted to the end.
        """
        return self._told(candidate, _free(candidate), self._settled(candidate, amplitude, rival), variance)

    def nearer(self, candidate: ChangeCandidate, amplitude: float) -> tuple[ChangeCandidate, float]:
        """Return a candidate at its fitted place, and its amplitude; arguments as for `refined`."""
        found = self._settled(candidate, amplitude, np.inf, STEPS_NEARER)
        place = zip([one.name for one in _free(candidate)[1:]], map(float, found.point[1:]), strict=True)
        return replace(candidate, shapes={**candidate.shapes, **dict(place)}), float(found.point[0])

    def _settled(
        self, candidate: ChangeCandidate, amplitude: float, rival: float, steps: int = MOST_STEPS
    ) -> _Fit:
        """Follow a fit to its end, or for so many steps."""
        free = _free(candidate)
        low, high = (np.array([getattr(one, side) for one in free]) for side in ("low", "high"))
        if candidate.two_sided:
            low[0] = -high[0]
        begun = np.array([amplitude, *[candidate.shapes[one.name] for one in free[1:]]])
        now = self._fit(candidate, free, np.clip(begun, low, high), np.array(self.temperatures), self._misfit)
        reach = np.array([np.inf, *[LARGEST_MOVE] * (len(free) - 1)])
        scale = np.array([one.sigma for one in free])
        for number in range(steps):
            if number >= STEPS_BEFORE_ABANDONING and now.chi2 > ABANDONED_CHI2_RATIO * rival:
                break
            solved = np.linalg.solve(now.matrix + np.diag(1e-6 / scale**2), now.gradient)
            step = np.asarray(solved, dtype=np.float64)
            ahead = now.chi2 - PROMISED_TIMES * float(now.gradient @ step)
            if number >= STEPS_BEFORE_JUDGING and ahead > rival + 2.0 * HOPELESS_EVIDENCE * self.noise:
                break
            step *= min(1.0, float((reach / np.maximum(np.abs(step), 1e-300)).min()))
            better = self._stepped(candidate, free, now, step, (low, high))
            if better is None:
                break
            moved, now = better.point - now.point, better
            if float(np.sqrt(moved @ now.matrix @ moved / now.noise)) < SETTLED_STEP:
                break
        return now

    def _stepped(
        self,
        candidate: ChangeCandidate,
        free: Sequence[Parameter],
        now: _Fit,
        step: Real,
        box: tuple[Real, Real],
    ) -> _Fit | None:
        """Take a step, or a part of it; None if none lowers chi2."""
        for halving in range(HALVINGS):
            point = np.clip(now.point + 0.5**halving * step, *box)
            try:
                tried = self._fit(candidate, free, point, now.temperatures_after(point - now.point), now.noise)
            except ValueError:  # off the plate, or in one of its holes
                continue
            if tried.chi2 < now.chi2:
                return tried
        return None

    @property
    def _misfit(self) -> float:
        return max(self.healthy[0] / self.healthy[1], 1.0)

    def _fit(
        self,
        candidate: ChangeCandidate,
        free: Sequence[Parameter],
        point: Real,
        temperatures: Real,
        noise: float,
    ) -> _Fit:
        values = candidate.values(
            float(point[0]), dict(zip([one.name for one in free[1:]], point[1:], strict=True))
        )
        effects = {candidate.effect: values}
        tangents = [(candidate.effect, one.name, values) for one in free]
        here = np.clip(temperatures, *self.baseline.temperature_range)
        said: list[DateEquations] = []
        for recording, temperature in zip(self.recordings, here, strict=True):
            twin = self.baseline.linearised(float(temperature), effects=effects, tangents=tangents)
            said.append(date_equations(recording, self.baseline.completed(twin), noise))
        return _Fit(
            point,
            np.sum([one.matrix for one in said], axis=0),
            np.sum([one.gradient for one in said], axis=0),
            float(sum(one.chi2 for one in said)),
            sum(one.dof for one in said),
            here,
            np.array([one.temperature for one in said]),
            np.array([one.by_change for one in said]),
            noise,
        )

    def _told(
        self, candidate: ChangeCandidate, free: Sequence[Parameter], fit: _Fit, variance: float
    ) -> RefinedChange:
        prior = np.array([one.sigma for one in free])
        covariance = np.linalg.inv(fit.matrix + np.diag(prior**-2.0))
        # what the baseline cannot tell counts as noise that is larger than stated, in place and amplitude alike
        louder = 1.0 + variance / max(float(covariance[0, 0]), 1e-300)
        scaled = np.eye(len(free)) + fit.matrix / self.noise * prior[:, None] * prior
        evidence = 0.5 * (self.healthy[0] - fit.chi2) / self.noise - 0.5 * float(np.linalg.slogdet(scaled)[1])
        sigma = np.sqrt(louder * np.diag(covariance))
        sigma[0] = np.hypot(sigma[0], TWIN_SHARE * fit.point[0])
        names = [one.name for one in free]
        values = candidate.values(
            float(fit.point[0]), dict(zip(names[1:], map(float, fit.point[1:]), strict=True))
        )
        return RefinedChange(
            candidate, values, dict(zip(names, map(float, sigma), strict=True)), evidence, fit.chi2 / fit.dof
        )

    def linear(self, candidate: ChangeCandidate, amplitude: float, sigma: float, variance: float) -> RefinedChange:
        """Take a candidate to which responses are linear from the linear search.

        Parameters
        ----------
        candidate : ChangeCandidate
        amplitude, sigma : float
            As estimated, `variance` included, SI.
        variance : float
            Of the amplitude, by what the baseline cannot tell.
        """
        information = 1.0 / max(sigma**2 - variance, 1e-300)
        drop = amplitude**2 * information
        evidence = linear_evidence(drop, information, candidate.parameter.sigma, self.noise)
        chi2, dof = self.healthy
        named = {candidate.parameter.name: sigma}
        return RefinedChange(candidate, candidate.values(amplitude), named, float(evidence), (chi2 - drop) / dof)


def linear_evidence(drop: Real | float, information: Real | float, prior: Real | float, noise: float) -> Real:
    """Log evidence of amplitudes over their being zero, nats.

    Parameters
    ----------
    drop : (C,) array_like
        Decrease of chi2.
    information : (C,) array_like
        Of the amplitudes, per unit squared.
    prior : (C,) array_like
        Their standard deviations beforehand.
    noise : float
        Chi2 per degree of freedom of the healthy panel.
    """
    ratio = np.asarray(prior) ** 2 * np.asarray(information) / noise
    return np.asarray(0.5 * np.asarray(drop) / noise * ratio / (1.0 + ratio) - 0.5 * np.log1p(ratio))


def _free(candidate: ChangeCandidate) -> list[Parameter]:
    """Parameters that are fitted: the amplitude, and the place."""
    shapes = [] if candidate.card is None else [p for p in candidate.card.parameters if p.name in ("x", "y")]
    return [candidate.parameter, *shapes]
