"""All dates in turn: alarms, and what the last ones name."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from analysis.arrays import Mask, Real
from analysis.checked_fields import check_finite, check_range
from analysis.health.baseline import HealthBaseline, SelfCheck
from analysis.health.evidence import SpanEstimate, limit, misfit_limit, span_estimate, spans
from analysis.health.naming import JudgedDate, Naming, information
from analysis.health.recording import (
    DatedRecording,
    DateEquations,
    ExpectedResponse,
    ExpectsResponses,
    date_equations,
    temperature_found,
)
from analysis.health.refined import RefinedChange


@dataclass(frozen=True)
class HealthDate:
    """One date.

    Attributes
    ----------
    date : str
    label : float or None
        Temperature as recorded, degrees Celsius; None where no thermometer was.
    temperature, sigma : float
        As the panel itself says, degrees Celsius, and its standard deviation, K.
    misfit : float
        Chi2 per degree of freedom, of the healthy panel.
    z : float
        Largest of all candidates and spans, in standard deviations.
    strongest : str
        Of which candidate.
    span : int
        Of how many last dates.
    alarm : bool
    skipped : str
        Why the date could not be judged; empty where it was.
    """

    date: str
    label: float | None
    temperature: float = 0.0
    sigma: float = 0.0
    misfit: float = 0.0
    z: float = 0.0
    strongest: str = ""
    span: int = 0
    alarm: bool = False
    skipped: str = ""

    def __post_init__(self) -> None:
        check_finite(self, "temperature", "z", *(() if self.label is None else ("label",)))
        check_range(self, 0.0, float("inf"), "sigma", "misfit")


@dataclass(frozen=True)
class NamedChange:
    """What has changed.

    Attributes
    ----------
    family : str
        Of `analysis.health.candidates.WORDS`; ``unknown`` where no candidate explains it.
    probability : float
        Of the family, among all.
    probabilities : tuple of (str, float)
        Of every family, the most likely first.
    change : RefinedChange or None
        None where it is unknown.
    since : str
        First of the dates that it rests on.
    span : int
        Number of these dates.
    trend : tuple of (float, float)
        Amplitude on every judged date by that date alone, and its standard deviation.
    also : tuple of RefinedChange
        The same at other places that are nearly as likely: patches that lie symmetrically cannot tell them apart.
    """

    family: str
    probability: float
    probabilities: tuple[tuple[str, float], ...]
    change: RefinedChange | None
    since: str
    span: int
    trend: tuple[tuple[float, float], ...] = field(default=(), repr=False)
    also: tuple[RefinedChange, ...] = ()

    def __post_init__(self) -> None:
        check_range(self, 0.0, 1.0, "probability")


@dataclass(frozen=True)
class HealthReport:
    """All dates, and what has changed up to the last.

    Attributes
    ----------
    rate : float
        False alarms per date, at most.
    limit, misfit_limit : float
        Of z, and of the misfit on one date.
    dates : tuple of HealthDate
        In order.
    found : NamedChange or None
        None where the last date gives no alarm.
    baseline_misfit : float
        Largest chi2 per degree of freedom of a temperature of the baseline, predicted from the others.
    order : int
        Of the polynomial that carries the twin's error over temperature.
    """

    rate: float
    limit: float
    misfit_limit: float
    dates: tuple[HealthDate, ...]
    found: NamedChange | None
    baseline_misfit: float
    order: int

    def __post_init__(self) -> None:
        check_range(self, 0.0, 1.0, "rate", above=True)
        check_range(self, 0.0, float("inf"), "limit", "misfit_limit", "baseline_misfit", above=True)

    @property
    def judged(self) -> tuple[HealthDate, ...]:
        """Dates that could be judged."""
        return tuple(one for one in self.dates if not one.skipped)

    @property
    def first_alarm(self) -> HealthDate | None:
        """The first date with an alarm; None without one."""
        return next((one for one in self.dates if one.alarm), None)


@dataclass
class HealthWatch:
    """Takes dates one after the other.

    Attributes
    ----------
    baseline : HealthBaseline
    check : SelfCheck
    rate : float
        False alarms per date, at most.
    expects : ExpectsResponses
        Healthy responses: the baseline itself, or a table of it.
    starts : sequence of ExpectedResponse
        From the nearest of these the search for a temperature begins.
    """

    baseline: HealthBaseline
    check: SelfCheck
    rate: float
    expects: ExpectsResponses
    starts: Sequence[ExpectedResponse]
    judged: list[JudgedDate] = field(init=False, default_factory=list)
    dates: list[HealthDate] = field(init=False, default_factory=list)
    _two_sided: Mask = field(init=False)
    _prior: Real = field(init=False)
    limit: float = field(init=False)

    def __post_init__(self) -> None:
        self._two_sided = np.array([one.two_sided for one in self.baseline.candidates])
        self._prior = np.array([one.parameter.sigma for one in self.baseline.candidates])
        self.limit = limit(self.rate, self._two_sided)

    def take(self, recordings: Sequence[DatedRecording]) -> HealthDate:
        """Judge the next date.

        Parameters
        ----------
        recordings : sequence of DatedRecording
            Of one date, at one or more temperatures.
        """
        told: list[tuple[DatedRecording, float, DateEquations]] = []
        for recording in recordings:
            temperature = temperature_found(recording, self.expects, self.starts)
            if temperature is not None:
                expected = self.expects.at(temperature)
                told.append((recording, temperature, date_equations(recording, expected)))
        first = recordings[0]
        if not told:
            low, high = self.expects.temperature_range
            found = HealthDate(
                first.date,
                first.label,
                skipped=f"its temperature is outside the baseline's {low:.1f} to {high:.1f} °C",
            )
            self.dates.append(found)
            return found
        now = JudgedDate(tuple(r for r, _, _ in told), tuple(t for _, t, _ in told), tuple(e for _, _, e in told))
        self.judged.append(now)
        found = self._told(first, now)
        self.dates.append(found)
        return found

    def _told(self, first: DatedRecording, now: JudgedDate) -> HealthDate:
        best, index, z = None, 0, -np.inf
        for span in spans(len(self.judged)):
            estimate = self._estimate(span)
            seen = self._sided(estimate)
            if seen.size and float(seen.max()) > z:
                best, index, z = estimate, int(seen.argmax()), float(seen.max())
        if best is None:
            raise ValueError("no candidates; a panel without patches and places cannot watch itself")
        misfit, bound = now.chi2 / now.dof, misfit_limit(self.rate, self.check.misfit, now.dof)
        return HealthDate(
            date=first.date,
            label=first.label,
            temperature=now.said[0].temperature,
            sigma=now.said[0].sigma,
            misfit=misfit,
            z=z,
            strongest=self.baseline.candidates[index].title,
            span=best.span,
            alarm=z > self.limit or misfit > bound,
        )

    def _estimate(self, span: int) -> SpanEstimate:
        said = [one for date in self.judged[-span:] for one in date.said]
        return replace(span_estimate(said, self.check.variance, self._prior), span=span)

    def _sided(self, estimate: SpanEstimate) -> Real:
        return np.where(self._two_sided, np.abs(estimate.z), estimate.z)

    def named(self) -> NamedChange:
        """Name what the last dates show; to be asked after an alarm."""
        if not self.judged:
            raise ValueError("no date was judged; take one first")
        span = self._named_span()
        seen = float(self._sided(self._estimate(span)).max()) > self.limit
        dates, estimate = self._nearer(self.judged[-span:])
        dof = sum(date.dof for date in dates)
        naming = Naming(
            self.baseline, self.check, tuple(dates), estimate, misfit_limit(self.rate, self.check.misfit, dof)
        )
        found = naming.found()
        since = dates[0].recordings[0].date
        best = found.best
        if best is None or not found.explained or not seen:
            return NamedChange("unknown", 1.0, found.shares, best, since, span)
        index = naming.nearest(best.candidate, best.values)
        alone = [span_estimate(date.said, self.check.variance, self._prior) for date in self.judged]
        trend = tuple((float(one.amplitude[index]), float(one.sigma[index])) for one in alone)
        return NamedChange(found.family, found.shares[0][1], found.shares, best, since, span, trend, found.also)

    def _named_span(self) -> int:
        """Find the number of last dates that the name rests on: where the strongest z is largest."""
        return max(spans(len(self.judged)), key=lambda span: float(self._sided(self._estimate(span)).max()))

    def _nearer(self, dates: Sequence[JudgedDate]) -> tuple[list[JudgedDate], SpanEstimate]:
        """Return dates at the temperatures found, or at those recorded: as one candidate explains them better.

        A large change moves resonances as many kelvins do, and takes the temperature found with it.
        """
        options = [list(dates), [self._as_recorded(date) for date in dates]]
        told: list[tuple[float, int, SpanEstimate]] = []
        for number, option in enumerate(options):
            said = [one for date in option for one in date.said]
            estimate = replace(span_estimate(said, self.check.variance, self._prior), span=len(dates))
            amplitude = np.where(self._two_sided, estimate.amplitude, np.maximum(estimate.amplitude, 0.0))
            drop = float((amplitude**2 * information(estimate, self.check)).max())
            told.append((sum(date.chi2 for date in option) - drop, number, estimate))
        _, number, estimate = min(told, key=lambda one: one[:2])
        return options[number], estimate

    def _as_recorded(self, date: JudgedDate) -> JudgedDate:
        """Judge a date at its recorded temperatures, those beyond the range at its end; without one, as found."""
        low, high = self.expects.temperature_range
        labels = zip(date.recordings, date.temperatures, strict=True)
        here = tuple(float(np.clip(found if one.label is None else one.label, low, high)) for one, found in labels)
        pairs = zip(date.recordings, here, strict=True)
        return JudgedDate(
            date.recordings, here, tuple(date_equations(one, self.expects.at(at)) for one, at in pairs)
        )

    def report(self) -> HealthReport:
        """Return all dates, and the name of what has changed if the last judged one gives an alarm."""
        judged = [one for one in self.dates if not one.skipped]
        found = self.named() if judged and judged[-1].alarm else None
        dof = self.judged[-1].dof if self.judged else 1
        return HealthReport(
            self.rate,
            self.limit,
            misfit_limit(self.rate, self.check.misfit, dof),
            tuple(self.dates),
            found,
            self.check.misfit,
            self.baseline.order,
        )
