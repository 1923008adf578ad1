"""What the last dates show: every kind of change fitted, and the one that explains them best.

The fit of a large change begins elsewhere. A change that moves resonances by more than their widths is not linear:
amplitudes and places by derivatives of the healthy panel are then wrong. Over resonances as wide as the change
moves them it is (`analysis.gap.data.sweeps`): nothing is approximated but that the change is linear. Noise
matters no longer beside a large change; what the twin does not know does, a share of the response.

Places lie closer here than in the search of small changes: near a nodal line of the strongest modes a place half
the distance of two sites away looks different.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.special import logsumexp

from analysis.arrays import Complex, Mask, Real
from analysis.checked_fields import check_shapes
from analysis.effect_card import Values
from analysis.gap.data.sweeps import cauchy_kernel
from analysis.health.baseline import HealthBaseline, SelfCheck
from analysis.health.candidates import DEPOLARIZATION, ChangeCandidate
from analysis.health.evidence import SpanEstimate
from analysis.health.recording import DatedRecording, DateEquations, ExpectedResponse, date_equations
from analysis.health.refined import ABANDONED_CHI2_RATIO, ChangeFit, RefinedChange, linear_evidence

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
"""From which a fit begins at most."""
TRIED_Z_SHARE = 0.7
"""Share of the best z squared from which a place is tried."""
LARGE_CHANGE = 10.0
"""Times the misfit that a healthy panel may have, beyond which resonances have moved by their widths: fits then
begin where the search over widened resonances says."""


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


@dataclass(frozen=True)
class FoundChange:
    """The families of changes after their fits.

    Attributes
    ----------
    family : str
        The most likely.
    shares : tuple of (str, float)
        Probability of every family, the most likely first.
    best : RefinedChange or None
        Of `family`; None where it was not fitted.
    also : tuple of RefinedChange
        The same at other places that are nearly as likely.
    explained : bool
        Whether the best leaves no more misfit than the healthy panel may have.
    """

    family: str
    shares: tuple[tuple[str, float], ...]
    best: RefinedChange | None
    also: tuple[RefinedChange, ...]
    explained: bool


WIDENED = 0.1
"""Half-width d, share of the frequency. 2 g at a corner of a plate of 130 g move resonances by up to 8 %; with
0.05 to 0.2 the right place explained twice to nine times as much as any other."""
TWIN_ERROR = 0.03
"""Share of the root mean square response: a twin knows to three per cent what a change does."""


@dataclass(frozen=True)
class BroadRecording:
    """A recording whose resonances are widened.

    Attributes
    ----------
    recording : DatedRecording
    kernel : (n, n) ndarray
        S, at the nodes.
    scale : (S, K, 1) ndarray
        Standard deviation of what the twin does not know.
    """

    recording: DatedRecording
    kernel: Real = field(repr=False)
    scale: Real = field(repr=False)

    def __post_init__(self) -> None:
        check_shapes(self, kernel="n n", scale="S K 1")

    @classmethod
    def of(cls, recording: DatedRecording) -> "BroadRecording":
        """Widen the resonances of a recording."""
        frequency = recording.nodes.frequency
        kernel = cauchy_kernel(frequency, WIDENED)
        widened = _values(recording) @ kernel.T
        scale = TWIN_ERROR * np.sqrt((np.abs(widened) ** 2).mean(axis=-1, keepdims=True))
        return cls(recording, kernel, scale)

    def white(self, values: Complex) -> Real:
        """Do what `DatedRecording.white` does."""
        return self._whitened(self.recording.mixed(values))

    @property
    def data(self) -> Real:
        """The recording, whitened."""
        return self._whitened(_values(self.recording))

    def _whitened(self, values: Complex) -> Real:
        widened = (values @ self.kernel.T) / self.scale
        flat = widened.reshape(*values.shape[:-3], -1)
        return np.concatenate([flat.real, flat.imag], axis=-1)

    def misfit(self, expected: ExpectedResponse) -> float:
        """Mean square of what a response leaves, 1 at least."""
        left = self.data - self.white(expected.response)
        return max(float(left @ left) / left.size, 1.0)


@dataclass(frozen=True)
class BroadStart:
    """Where the fit of an effect begins.

    Attributes
    ----------
    candidate : ChangeCandidate
        At its place.
    amplitude : float
        SI.
    left : float
        Chi2 of the widened recordings that it leaves.
    """

    candidate: ChangeCandidate
    amplitude: float
    left: float


def broad_starts(
    baseline: HealthBaseline, recordings: Sequence[BroadRecording], temperatures: Sequence[float]
) -> dict[str, BroadStart]:
    """Return the best start of every family.

    Parameters
    ----------
    baseline : HealthBaseline
    recordings : sequence of BroadRecording
        Of one date.
    temperatures : sequence of float
        Of each, degrees Celsius.
    """
    unplaced = [one for one in baseline.candidates if not one.placed]
    lost = [one for one in unplaced if one.effect == DEPOLARIZATION]
    candidates = [*closer(baseline.candidates), *(one for one in unplaced if one not in lost), *lost]
    tangents = [one.tangent for one in candidates if one.tangent is not None]
    matrix, gradient, chi2 = np.zeros(len(candidates)), np.zeros(len(candidates)), 0.0
    for recording, temperature in zip(recordings, temperatures, strict=True):
        twin = baseline.linearised(temperature, tangents=tangents)
        columns = np.concatenate([twin.by_change, baseline.lost(twin.transfer)])
        expected = baseline.completed(replace(twin, by_change=columns))
        said = date_equations(recording, expected, recording.misfit(expected))
        matrix += np.diag(said.matrix)
        gradient += said.gradient
        chi2 += said.chi2
    safe = np.maximum(matrix, 1e-300)
    amplitude = gradient / safe
    either = np.array([one.two_sided for one in candidates])
    amplitude = np.where(either, amplitude, np.maximum(amplitude, 0.0))
    drop = amplitude**2 * matrix
    found: dict[str, BroadStart] = {}
    for index in np.argsort(-drop, kind="stable"):
        one = candidates[index]
        found.setdefault(one.family, BroadStart(one, float(amplitude[index]), float(chi2 - drop[index])))
    return found


def closer(candidates: Sequence[ChangeCandidate]) -> list[ChangeCandidate]:
    """Return candidates that have places, each effect at the closer places of its card."""
    found: list[ChangeCandidate] = []
    seen: set[tuple[str, str]] = set()
    for one in candidates:
        if not one.placed or one.card is None or (one.effect, one.parameter.name) in seen:
            continue
        seen.add((one.effect, one.parameter.name))
        found += [replace(one, shapes={**one.shapes, **site}) for site in one.card.closer_sites or one.card.sites]
    return found


def _values(recording: DatedRecording) -> Complex:
    """Return recorded responses at the nodes, (S, K, n)."""
    return np.array([recording.nodes.at_nodes(one.coefficients) for one in recording.sweeps])


@dataclass
class Naming:
    """Names what some dates show.

    Attributes
    ----------
    baseline : HealthBaseline
    check : SelfCheck
    dates : tuple of JudgedDate
    estimate : SpanEstimate
        Of these dates.
    misfit_limit : float
        Chi2 per degree of freedom that a healthy panel may have.
    """

    baseline: HealthBaseline
    check: SelfCheck
    dates: tuple[JudgedDate, ...]
    estimate: SpanEstimate
    misfit_limit: float
    _refined: dict[str, RefinedChange] = field(init=False, default_factory=dict)
    _also: dict[str, tuple[RefinedChange, ...]] = field(init=False, default_factory=dict)
    _rival: float = field(init=False, default=np.inf)

    def found(self) -> FoundChange:
        """Fit the families that may explain the dates."""
        large = self._healthy[0] / self._healthy[1] > LARGE_CHANGE * self._bound
        searches = [self._by_derivatives, self._by_widened]
        for search in reversed(searches) if large else searches:
            if not self._explained:
                search()
        judged = {
            name: self._refined[name].evidence if name in self._refined else one
            for name, one in self._evidence.items()
        }
        total = float(logsumexp(list(judged.values())))
        order = sorted(judged, key=lambda name: -judged[name])
        shares = tuple((name, float(np.exp(judged[name] - total))) for name in order)
        best = self._refined.get(order[0])
        explained = best is not None and best.misfit <= self._bound
        return FoundChange(order[0], shares, best, self._also.get(order[0], ()), explained)

    def nearest(self, candidate: ChangeCandidate, values: Values) -> int:
        """Index of the baseline's candidate of the same amplitude whose place is nearest to that of `values`."""
        alike = [
            (0.0 if not one.placed else _distance(one.shapes, values), index)
            for index, one in enumerate(self.baseline.candidates)
            if (one.effect, one.parameter.name, one.patch)
            == (candidate.effect, candidate.parameter.name, candidate.patch)
            and (one.placed or one.shapes == candidate.shapes)
        ]
        return min(alike)[1]

    @cached_property
    def _healthy(self) -> tuple[float, int]:
        return sum(date.chi2 for date in self.dates), sum(date.dof for date in self.dates)

    @property
    def _bound(self) -> float:
        chi2, dof = self._healthy
        return self.misfit_limit + UNEXPLAINED_SHARE * chi2 / dof

    @property
    def _explained(self) -> bool:
        return any(one.misfit <= self._bound for one in self._refined.values())

    @cached_property
    def _fit(self) -> ChangeFit:
        return ChangeFit(
            self.baseline,
            tuple(one for date in self.dates for one in date.recordings),
            tuple(one for date in self.dates for one in date.temperatures),
            self._healthy,
            max(self.check.usual, 1.0),
        )

    @cached_property
    def _evidence(self) -> dict[str, float]:
        """Log evidence of every family over a healthy panel, by the linear search, its members averaged."""
        known = information(self.estimate, self.check)
        prior = np.array([one.parameter.sigma for one in self.baseline.candidates])
        single = linear_evidence(self._amplitude**2 * known, known, prior, self._fit.noise)
        families = np.array([one.family for one in self.baseline.candidates])
        return {
            str(name): float(logsumexp(single[families == name]) - np.log((families == name).sum()))
            for name in np.unique(families)
        }

    @property
    def _two_sided(self) -> Mask:
        return np.array([one.two_sided for one in self.baseline.candidates])

    @property
    def _amplitude(self) -> Real:
        return np.where(self._two_sided, self.estimate.amplitude, np.maximum(self.estimate.amplitude, 0.0))

    def _keep(self, family: str, found: RefinedChange, also: tuple[RefinedChange, ...] = ()) -> None:
        if family not in self._refined or found.evidence > self._refined[family].evidence:
            self._refined[family], self._also[family] = found, also
        self._rival = min(self._rival, found.misfit * self._healthy[1])

    def _by_widened(self) -> None:
        """Fit the families from where the last date's recordings with widened resonances say."""
        date = self.dates[-1]
        recordings = tuple(BroadRecording.of(one) for one in date.recordings)
        starts = broad_starts(self.baseline, recordings, date.temperatures)
        least = min(one.left for one in starts.values())
        healthy = sum(one.data.size for one in recordings)
        widened = ChangeFit(self.baseline, recordings, date.temperatures, (float(healthy), healthy), 1.0)
        for family in sorted(starts, key=lambda name: starts[name].left):
            start = starts[family]
            if start.left > ABANDONED_CHI2_RATIO * least or start.amplitude == 0.0:
                continue
            candidate, amplitude = start.candidate, start.amplitude
            if candidate.effect == DEPOLARIZATION:
                self._keep(family, self._linear(self.nearest(candidate, candidate.shapes)))
                continue
            if candidate.placed:
                candidate, amplitude = widened.nearer(candidate, amplitude)
            variance = float(self.check.variance[self.nearest(candidate, candidate.shapes)])
            self._keep(family, self._fit.refined(candidate, amplitude, variance, self._rival))

    def _by_derivatives(self) -> None:
        """Fit the families that are likely by derivatives of the healthy panel."""
        ranked = sorted(self._evidence.values(), reverse=True)
        least = min(REFINED_EVIDENCE_SHARE * ranked[0], ranked[min(FEWEST_REFINED, len(ranked)) - 1])
        for family in sorted(self._evidence, key=lambda name: -self._evidence[name]):
            if self._evidence[family] >= least:
                self._keep(family, *self._of_family(family))

    def _linear(self, index: int) -> RefinedChange:
        sigma, variance = float(self.estimate.sigma[index]), float(self.check.variance[index])
        begun = max(float(self.estimate.amplitude[index]), sigma)
        return self._fit.linear(self.baseline.candidates[index], begun, sigma, variance)

    def _of_family(self, family: str) -> tuple[RefinedChange, tuple[RefinedChange, ...]]:
        """Fit the best members of a family; return the best, and those at other places that are as likely."""
        estimate, candidates = self.estimate, self.baseline.candidates
        sided = np.where(self._two_sided, np.abs(estimate.amplitude), np.maximum(estimate.amplitude, 0.0))
        z = sided * np.sqrt(information(estimate, self.check))
        mine = [index for index, one in enumerate(candidates) if one.family == family]
        first = max(mine, key=lambda index: float(z[index]))
        place, found = candidates[first], list[RefinedChange]()
        further = [first]
        while further and len(found) < MOST_PLACES:
            index = max(further, key=lambda index: float(z[index]))
            if found and z[index] ** 2 <= TRIED_Z_SHARE * z[first] ** 2:
                break
            one = candidates[index]
            if one.effect == DEPOLARIZATION:
                found.append(self._linear(index))
            else:
                begun = float(estimate.amplitude[index])
                begun = begun if one.two_sided else max(begun, float(estimate.sigma[index]))
                found.append(self._fit.refined(one, begun, float(self.check.variance[index]), self._rival))
            self._rival = min(self._rival, found[-1].misfit * self._healthy[1])
            if not place.placed:
                break
            further = [
                other
                for other in (mine if len(found) == 1 else further)
                if candidates[other].effect == place.effect
                and _distance(candidates[other].shapes, one.shapes) > OTHER_PLACE
            ]
        best = max(found, key=lambda one: one.evidence)
        alike = tuple(
            one
            for one in found
            if one is not best
            and best.evidence - one.evidence < ALIKE_EVIDENCE
            and _distance(one.values, best.values) > OTHER_PLACE
        )
        return best, alike


def information(estimate: SpanEstimate, check: SelfCheck) -> Real:
    """Information (C,) on amplitudes by the dates alone, per unit squared; 0 where nothing is seen."""
    seen = np.isfinite(estimate.sigma)
    left = np.where(seen, estimate.sigma, 1.0) ** 2 - check.variance
    return np.where(seen, 1.0 / np.maximum(left, 1e-300), 0.0)


def _distance(one: Values, other: Values) -> float:
    return float(np.hypot(one["x"] - other["x"], one["y"] - other["y"]))
