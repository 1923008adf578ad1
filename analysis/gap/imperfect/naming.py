"""Which effects are named beside a discrepancy, and why; they are tried on what they were not fitted to.

An effect that acts on one mode only hides among the scatter of modes; one that is there predicts the others.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.gap_fit import GapFit, relative_misfit
from analysis.gap.imperfect.search import Imperfect, ImperfectResult, ImperfectSearch, over_all_sweeps
from analysis.gap.search.confidence import NO_EFFECT, equivalents, probability
from analysis.gap.search.context import SearchContext
from analysis.gap.search.held_out import LEAST_TEMPERATURES, HeldOut, Split, fit_and_try
from analysis.gap.search.observability import signal_cosine
from analysis.gap.search.refit import at_few_temperatures
from analysis.gap.thresholds import LEAST_GAIN, LEAST_PROBABILITY, NAMED_SHARE, NO_DOUBT

BLOCKS, EVERY = 18, 3
"""Number of blocks of the band, some two modes each, and how many of them there are for each that is held out."""


@dataclass(frozen=True)
class _Tried:
    """A twin on data held out: chi2 in units of the noise, misfit, log probability beside its discrepancy."""

    test: GapSweeps
    chi2: float
    dof: float
    misfit: float
    log_probability: float

    @classmethod
    def of(cls, plain: SearchContext, what: str, twin: Imperfect) -> "_Tried":
        sweeps = twin.context.sweeps
        split = _split(sweeps, what)
        fit = fit_and_try(plain.model, sweeps, split, twin.fit, plain.executor)
        places = split.test.original_places(sweeps)
        penalty = twin.shape.only(places).penalty(split.test, twin.scatter)
        return cls(
            test=split.test,
            chi2=float((np.abs(split.test.weights.undone(fit.residual)) ** 2).sum()),
            dof=fit.dof,
            misfit=relative_misfit(split.test, fit),
            log_probability=-0.5 * fit.total - penalty,
        )


@dataclass(frozen=True)
class Surety:
    """How sure an effect is.

    Attributes
    ----------
    gain : float
        Log evidence over the best twin without it, nats.
    against : mapping of str to float
        Log evidence of no effect, and of every other effect in its place, relative to it, nats.
    equivalent : tuple of str
        Effects that this campaign cannot tell from it.
    probability : float
        That it, or an equivalent, is there.
    """

    gain: float
    against: Mapping[str, float]
    equivalent: tuple[str, ...]
    probability: float

    @property
    def something(self) -> float:
        """Probability that it or another effect of the library is there, against nothing and an unknown cause."""
        return probability({name: self.against[name] for name in NO_EFFECT if name in self.against}, ())


@dataclass(frozen=True)
class BesideDiscrepancy:
    """Result of a comparison in which no twin comes down to the noise.

    Attributes
    ----------
    found : ImperfectResult
        At a few temperatures.
    baseline, final : GapFit
        Of all sweeps, without and with the effects found; residuals in units of the noise.
    tried : tuple of HeldOut
        None where no effect was found.
    sure : mapping of str to Surety
        By effect.
    claimed : bool
        Whether the effects are named; else they are hints.
    reason : str
    """

    found: ImperfectResult
    baseline: GapFit
    final: GapFit
    tried: tuple[HeldOut, ...]
    sure: Mapping[str, Surety]
    claimed: bool
    reason: str


def beside_discrepancy(context: SearchContext, baseline: GapFit, known: GapFit | None = None) -> BesideDiscrepancy:
    """Search beside a discrepancy, and decide what is named.

    Parameters
    ----------
    context : SearchContext
        Of all sweeps, unweighted.
    baseline : GapFit
        Without effects.
    known : GapFit, optional
        With effects that explain most of a gap, from which the search goes on: where resonances are off by more
        than their widths, what twin and data differ by is no scatter, and nothing would stand out of it.

    Returns
    -------
    BesideDiscrepancy
    """
    part, begun = at_few_temperatures(context, baseline)
    few = context.of(part.sweeps)
    near = None if known is None else at_few_temperatures(context, known)[1]
    found = ImperfectSearch(few, begun, near).run()
    context.report("beside a discrepancy", 0.8)
    before = over_all_sweeps(context, baseline.state, found.baseline)
    if not found.final.effects:
        return BesideDiscrepancy(found, before, before, (), {}, False, _said(found, "no effect stands out of it"))
    after = over_all_sweeps(context, baseline.state, found.final)
    tried = tried_elsewhere(few, found)
    sure = _sure(found)
    claimed, reason = _decided(context, sure, before, after, tried)
    return BesideDiscrepancy(found, before, after, tried, sure, claimed, _said(found, reason))


def _decided(
    context: SearchContext, sure: Mapping[str, Surety], before: GapFit, after: GapFit, tried: Sequence[HeldOut]
) -> tuple[bool, str]:
    share = _explained(context, before, after)
    failed = next((one for one in tried if one.gain is None or one.gain <= 0.0), None)
    if failed is not None:
        return False, f"what was found does not hold on {failed.what}, which was left out"
    if share < NAMED_SHARE:
        return False, f"the best effects explain {100 * share:.0f} % of the gap only"
    doubt = doubted(sure)
    if doubt:
        return False, doubt
    return True, f"{100 * share:.0f} % of the gap is explained"


def doubt_of_scatter(context: SearchContext, baseline: GapFit, fit: GapFit, sure: Mapping[str, Surety]) -> str:
    """Say that modes which scatter explain a gap as well as some effects that close it; empty where they do not.

    Beside noise alone a few effects can imitate what moves every mode a little: a soft foundation of 0.1 % in
    frequency was two springs, 42 nats above nothing, and 6 nats above modes that scatter.
    """
    if not sure or min(one.gain for one in sure.values()) > NO_DOUBT:
        return ""
    part, begun = at_few_temperatures(context, baseline)
    gain = ImperfectSearch(context.of(part.sweeps), begun, at_few_temperatures(context, fit)[1]).over_scatter()
    if gain is None or gain >= LEAST_GAIN * len(sure):
        return ""
    names = ", ".join(sure)
    return (
        f"hints, not names: modes that scatter by themselves explain the gap as well as {names} ({gain:.1f} nats)"
    )


def doubted(sure: Mapping[str, Surety]) -> str:
    """Say which of some effects may well be nothing, or a cause that no library has; empty where none is."""
    unsure = [(one.something, name) for name, one in sure.items() if one.something < LEAST_PROBABILITY]
    if not unsure:
        return ""
    said = ", ".join(f"{name} {share:.2f}" for share, name in sorted(unsure, reverse=True))
    least = f"{LEAST_PROBABILITY:g}"
    return f"hints, not names: their probability against nothing and an unknown cause is below {least} ({said})"


def _explained(context: SearchContext, before: GapFit, after: GapFit) -> float:
    """Share of the excess over the noise that effects explain."""
    excess = context.excess(before)
    return 1.0 - max(context.excess(after), 0.0) / excess if excess > 0.0 else 0.0


def _said(found: ImperfectResult, reason: str) -> str:
    scatter, loss = found.scatter[1], float(np.exp(found.final.fit.state.laws[:, 2].mean()))
    return (
        f"{reason}; resonances scatter about those of the twin by {100 * scatter.frequency:.2g} % in frequency, "
        f"{200 * scatter.damping / loss:.2g} % in damping and {100 * scatter.amplitude:.2g} % in size"
    )


def _sure(found: ImperfectResult) -> dict[str, Surety]:
    sure = {}
    for name in found.final.effects:
        rivals, gain = found.rivals.get(name, {}), found.gains[name]
        alike = equivalents(rivals, {other: signal_cosine(found.last, name, other) for other in rivals})
        others = {"nothing": -gain, **rivals}
        sure[name] = Surety(gain, others, alike, probability(others, alike))
    return sure


def tried_elsewhere(plain: SearchContext, found: ImperfectResult) -> tuple[HeldOut, ...]:
    """Try the effects found on a third of the band, and on every second temperature.

    Parameters
    ----------
    plain : SearchContext
        Unweighted, of the sweeps that were searched.
    found : ImperfectResult

    Returns
    -------
    tuple of HeldOut
    """
    ways = ["every third part of the band"]
    if len(plain.sweeps.groups.reference) >= LEAST_TEMPERATURES:
        ways.append("every second temperature")
    return tuple(_tried(plain, what, found) for what in ways)


def _split(sweeps: GapSweeps, what: str) -> Split:
    if "temperature" in what:
        count = len(sweeps.groups.reference)
        even, odd = list(range(0, count, 2)), list(range(1, count, 2))
        return Split(what, sweeps.only_groups(even), sweeps.only_groups(odd), laws_free=True)
    shape = sweeps.rows.shape
    block = np.arange(shape[-1]) * BLOCKS // shape[-1]
    out = np.broadcast_to(block % EVERY == 1, shape)
    return Split(what, sweeps.masked(~out), sweeps.masked(out), laws_free=False)


def _tried(plain: SearchContext, what: str, found: ImperfectResult) -> HeldOut:
    before = _Tried.of(plain, what, found.baseline)
    try:
        after = _Tried.of(plain, what, found.final)
    except ValueError:  # what was learnt leaves the certified range of the twin
        after = before
    chi2, dof = after.test.between
    gap = before.chi2 - before.dof
    return HeldOut(
        what=what,
        baseline_chi2=before.chi2 + chi2,
        final_chi2=after.chi2 + chi2,
        dof=after.dof + dof,
        baseline_misfit=before.misfit,
        final_misfit=after.misfit,
        closure=float(np.clip(1.0 - (after.chi2 - after.dof) / gap, 0.0, 1.0)) if gap > 0.0 else None,
        closure_sigma=None,
        gain=after.log_probability - before.log_probability,
    )
