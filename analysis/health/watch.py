"""All dates in turn: alarms, and what the last ones name."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.special import logsumexp

from analysis.arrays import Mask, Real
from analysis.effect_card import Values
from analysis.health.baseline import HealthBaseline
from analysis.health.candidates import DEPOLARIZATION
from analysis.health.evidence import SpanEstimate, limit, misfit_limit, span_estimate, spans
from analysis.health.expected import ExpectedResponse, ExpectsResponses
from analysis.health.health_report import HealthDate, HealthReport, NamedChange
from analysis.health.recording import DatedRecording, DateEquations, date_equations, temperature_found
from analysis.health.refined import ChangeFit, RefinedChange, linear_evidence
from analysis.health.self_check import SelfCheck

REFINED_EVIDENCE_SHARE = 0.5
"""Share of the largest log evidence, by the linear search, from which a family is fitted with its place: what is
linear about the healthy panel is wrong by a tenth or two of a change of 20 %."""
FEWEST_REFINED = 3
"""Families that are fitted whatever their evidence."""
OTHER_PLACE = 0.05
"""m: a second place this far from the best one is tried, too, where it explains nearly as much: on a rectangle the
places mirrored in its axes shift resonances alike, and only the patches tell them apart."""
UNEXPLAINED_SHARE = 1e-3
"""Share of the misfit that the right effect may leave: a twin knows to three per cent what a change does."""
ALIKE_EVIDENCE = 3.0
"""Nats: a place that is as likely but for a factor of twenty is named beside the best one."""
MOST_PLACES = 4
"""From which a fit begins at most: a mass at a corner may seem to lie on the edge beside it."""
TRIED_Z_SHARE = 0.7
"""Share of the best z squared from which it is tried."""


@dataclass(frozen=True)
class JudgedDate:
    """A date with its recordings, as found.

    Attributes
    ----------
    recordings : tuple of DatedRecording
    temperatures : tuple of float
        Degrees Celsius.
    said : tuple of DateEquations
    """

    recordings: tuple[DatedRecording, ...] = field(repr=False)
    temperatures: tuple[float, ...]
    said: tuple[DateEquations, ...] = field(repr=False)

    @property
    def chi2(self) -> float:
        """Of the healthy panel."""
        return sum(one.chi2 for one in self.said)

    @property
    def dof(self) -> int:
        """Degrees of freedom."""
        return sum(one.dof for one in self.said)


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
        healthy, dof = sum(date.chi2 for date in dates), sum(date.dof for date in dates)
        fit = ChangeFit(
            self.baseline,
            tuple(one for date in dates for one in date.recordings),
            tuple(one for date in dates for one in date.temperatures),
            (healthy, dof),
            max(self.check.usual, 1.0),
        )
        evidence = self._evidence(estimate, fit.noise)
        ranked = sorted(evidence.values(), reverse=True)
        least = min(REFINED_EVIDENCE_SHARE * ranked[0], ranked[min(FEWEST_REFINED, len(ranked)) - 1])
        refined: dict[str, RefinedChange] = {}
        also: dict[str, tuple[RefinedChange, ...]] = {}
        rival = np.inf
        for name in sorted(evidence, key=lambda name: -evidence[name]):
            if evidence[name] >= least:
                refined[name], also[name] = self._refined(name, estimate, fit, rival)
                rival = min(rival, refined[name].misfit * dof)
        judged = {name: refined[name].evidence if name in refined else one for name, one in evidence.items()}
        total = float(logsumexp(list(judged.values())))
        order = sorted(judged, key=lambda name: -judged[name])
        shares = tuple((name, float(np.exp(judged[name] - total))) for name in order)
        since = dates[0].recordings[0].date
        best = refined.get(order[0])
        bound = misfit_limit(self.rate, self.check.misfit, dof) + UNEXPLAINED_SHARE * healthy / dof
        if best is None or best.misfit > bound or not seen:
            return NamedChange("unknown", 1.0, shares, best, since, span)
        index = self.baseline.candidates.index(best.candidate)
        alone = [span_estimate(date.said, self.check.variance, self._prior) for date in self.judged]
        trend = tuple((float(one.amplitude[index]), float(one.sigma[index])) for one in alone)
        return NamedChange(order[0], shares[0][1], shares, best, since, span, trend, also[order[0]])

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
            drop = float((amplitude**2 * self._information(estimate)).max())
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

    def _evidence(self, estimate: SpanEstimate, noise: float) -> dict[str, float]:
        """Log evidence of every family over a healthy panel, by the linear search, its members averaged."""
        amplitude = np.where(self._two_sided, estimate.amplitude, np.maximum(estimate.amplitude, 0.0))
        information = self._information(estimate)
        single = linear_evidence(amplitude**2 * information, information, self._prior, noise)
        families = np.array([one.family for one in self.baseline.candidates])
        return {
            str(name): float(logsumexp(single[families == name]) - np.log((families == name).sum()))
            for name in np.unique(families)
        }

    def _information(self, estimate: SpanEstimate) -> Real:
        """Of the amplitudes by the dates alone, per unit squared; 0 where nothing is seen."""
        seen = np.isfinite(estimate.sigma)
        left = np.where(seen, estimate.sigma, 1.0) ** 2 - self.check.variance
        return np.where(seen, 1.0 / np.maximum(left, 1e-300), 0.0)

    def _refined(
        self, family: str, estimate: SpanEstimate, fit: ChangeFit, rival: float
    ) -> tuple[RefinedChange, tuple[RefinedChange, ...]]:
        """Fit the best members of a family; return the best, and those at other places that are as likely."""
        sided = np.where(self._two_sided, np.abs(estimate.amplitude), np.maximum(estimate.amplitude, 0.0))
        z = sided * np.sqrt(self._information(estimate))
        candidates, variance = self.baseline.candidates, self.check.variance
        mine = [index for index, one in enumerate(candidates) if one.family == family]
        first = max(mine, key=lambda index: float(z[index]))
        place, found = candidates[first], list[RefinedChange]()
        further, bound = [first], misfit_limit(self.rate, self.check.misfit, fit.healthy[1])
        while further and len(found) < MOST_PLACES:
            index = max(further, key=lambda index: float(z[index]))
            explained = bool(found) and min(one.misfit for one in found) <= bound
            if found and (explained or not place.placed) and z[index] ** 2 <= TRIED_Z_SHARE * z[first] ** 2:
                break
            one, begun = candidates[index], max(float(estimate.amplitude[index]), float(estimate.sigma[index]))
            if one.effect == DEPOLARIZATION:
                found.append(fit.linear(one, begun, float(estimate.sigma[index]), float(variance[index])))
            else:
                begun = float(estimate.amplitude[index]) if one.two_sided else begun
                found.append(fit.refined(one, begun, float(variance[index]), rival))
            rival = min(rival, found[-1].misfit * fit.healthy[1])
            if not place.placed:
                break
            further = [
                other
                for other in (mine if len(found) == 1 else further)
                if candidates[other].effect == place.effect and _apart(candidates[other].shapes, one.shapes)
            ]
        best = max(found, key=lambda one: one.evidence)
        alike = tuple(
            one
            for one in found
            if one is not best
            and best.evidence - one.evidence < ALIKE_EVIDENCE
            and _apart(one.values, best.values)
        )
        return best, alike

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


def _apart(one: Values, other: Values) -> bool:
    return float(np.hypot(one["x"] - other["x"], one["y"] - other["y"])) > OTHER_PLACE
