"""The gap workflow from FRFs to a report, and the verdict on what its search found."""

import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.estimates import Estimate, FittedLaws, doubts
from analysis.experiment import Protocol
from analysis.gap.data.noise import NoiseCheck, NumericalFloor
from analysis.gap.data.preparation import prepare, sharpest
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.gap_fit import GapFit, fitted_sheet, relative_misfit
from analysis.gap.fitting.normal_equations import whiten_all
from analysis.gap.fitting.residual_map import Signature, cell_sigma, residual_map, whiteness
from analysis.gap.fitting.schur_complement import schur_complement
from analysis.gap.fitting.state import starting_state
from analysis.gap.imperfect.discrepancy import Discrepancy
from analysis.gap.imperfect.naming import BesideDiscrepancy, Surety, beside_discrepancy, doubt_of_scatter, doubted
from analysis.gap.report import Agreement, CandidateRow, GapReport, NamedEffect, PlainTwin, Verdict
from analysis.gap.search.confidence import against, equivalents, noise_evidence, probability, unknown_evidence
from analysis.gap.search.context import SearchContext, explained
from analysis.gap.search.held_out import HeldOut, held_out, splits
from analysis.gap.search.observability import signal_cosine, tangent_cosines
from analysis.gap.search.score_test import Candidate
from analysis.gap.search.stepwise import SearchResult, stepwise_search
from analysis.gap.thresholds import EXPLAINED, NAMED_SHARE, Z_FLOOR
from analysis.progress import Progress
from analysis.recordings.frf import Frf
from analysis.twin_model import HeldEffects, Remade, Tangent, TwinModel
from analysis.updated import Updated


@dataclass(frozen=True)
class Judgement:
    """A verdict, and the reason as text."""

    verdict: Verdict
    reason: str


def find_gap(
    frf: Frf,
    updated: Updated,
    model: TwinModel,
    protocol: Protocol,
    executor: Executor,
    *,
    floor: NumericalFloor | None = None,
    remade: Remade | None = None,
    progress: Progress | None = None,
    clock: Callable[[], float] = time.perf_counter,
) -> GapReport:
    """Find where twin and data disagree, and which effects the twin lacks.

    Parameters
    ----------
    frf : Frf
        Measured; lines in `frf.excluded` take no part.
    updated : Updated
        Model updating of the same sweeps, from which the baseline starts.
    model : TwinModel
        The twin with its library. A declared quantity that the data push beyond its tolerance is released where an
        effect replaces it, and the search is made again.
    protocol : Protocol
        Gives the ramp rate.
    executor : Executor
        Sweeps are linearised on it.
    floor : NumericalFloor, optional
        Discretisation error of the twin; by default the usual one of a converged twin.
    remade : callable, optional
        Asked with the values of declared quantities that a fit found beyond their tolerances: gives the twin with
        an effect that may replace one of them, or None where `model` has it already.
    progress : callable, optional
        Called with a stage's name and the share of it done.
    clock : callable
        Time, s, for the duration in the report.

    Returns
    -------
    GapReport

    Raises
    ------
    ValueError
        Where the stated noise cannot be trusted, or the lines are too few.
    """
    begun = clock()
    report: Progress = progress or (lambda stage, share: None)
    report("baseline", 0.0)
    sweeps, noise = prepare(frf, protocol, updated, floor=floor)
    around = HeldEffects.around(model)
    context, found = _searched(around, updated, sweeps, noise, executor, report, remade or (lambda _: None))
    model, baseline = context.model, found.baseline
    tried: list[HeldOut] = []
    if found.effects:
        significant = Z_FLOOR * float(np.sqrt(2.0 * baseline.dof))
        ways = splits(sweeps)
        for done, split in enumerate(ways):
            report("held-out data", done / len(ways))
            tried.append(held_out(model, sweeps, split, baseline, found.fit, executor, significant))
    judgement = judge(context, found, tried[0] if tried else None)
    claimed = found.effects if judgement.verdict == "explained" else ()
    sure = {name: _surety(context, found, name) for name in claimed}
    doubt = doubted(sure) or _at_bounds(found.fit, sure) or doubt_of_scatter(context, baseline, found.fit, sure)
    if doubt:
        judgement = Judgement("unknown", doubt)
    conclusion = _concluded(context, found, tried, judgement, sure)
    if judgement.verdict == "unknown":
        most = context.far(baseline) and explained(context, baseline, found.fit) >= EXPLAINED
        known = found.fit if most and tried and tried[0].holds else None
        conclusion = _beside(context, baseline, beside_discrepancy(context, baseline, known))
    notes = [
        *noise.notes,
        *(floor.notes if floor is not None else ()),
        *([doubt] if doubt else []),
        conclusion.reason,
        *(_hints(context, found, tried[0]) if tried and conclusion.verdict == "unknown" else ()),
    ]
    if float(np.exp(conclusion.final.state.laws[:, 2].min())) < sharpest(updated.material):
        notes.append("some resonances are sharper than the nodes resolve; the residual may show it")
    notes += doubts(conclusion.issued.declared_quantities(model.tolerance_cards))
    unseen = [o.effect for o in found.seen if not o.observable]  # `observability` says what each needs
    notes += [f"not observable with this data: {', '.join(unseen)}"] if unseen else []
    alone = () if judgement.verdict == "none" else signatures(context, found)
    report("done", 1.0)
    return _report(updated, context, found, conclusion, alone, tuple(notes), clock() - begun)


def _at_bounds(fit: GapFit, sure: Collection[str]) -> str:
    """Say which effects that would be named have become others; empty where none has."""
    others = [name for name in fit.become_another if name in sure]
    if not others:
        return ""
    return f"hints, not names: {', '.join(others)}: not told from the end of its range, where it is another effect"


def _hints(context: SearchContext, found: SearchResult, tried: HeldOut) -> Iterator[str]:
    """Say what takes most of the gap, on data left out, too, and is still no name beside the scatter of modes."""
    share = explained(context, found.baseline, found.fit)
    if share < NAMED_SHARE or tried.closure is None or tried.closure < NAMED_SHARE:
        return
    for name, values in found.fit.state.effects.items():
        card = context.model.cards[name]
        said = ", ".join(f"{p.name} {values[p.name]:.3g} {p.unit}" for p in card.parameters)
        yield f"a hint, no name: {name} ({said})"
    yield (
        f"these take {100 * share:.0f} % of the gap, and {100 * tried.closure:.0f} % of it on data left out "
        f"({tried.what}); look there first"
    )


@dataclass(frozen=True)
class _Conclusion:
    """What a comparison came to: the twins before and after, what is named or hinted at, and why.

    `plain` is the twin without effects that is issued: beside a discrepancy, where one is left.
    """

    verdict: Verdict
    reason: str
    baseline: GapFit
    final: GapFit
    plain: GapFit
    effects: tuple[NamedEffect, ...]
    held_out: tuple[HeldOut, ...]
    scatter: tuple[Discrepancy, Discrepancy] | None = None

    @property
    def issued(self) -> GapFit:
        """The twin that is issued: beside noise alone, declared quantities would follow what is not named."""
        return self.plain if self.verdict == "unknown" else self.final


def _concluded(
    context: SearchContext,
    found: SearchResult,
    tried: Sequence[HeldOut],
    judgement: Judgement,
    sure: Mapping[str, Surety],
) -> _Conclusion:
    """Conclude from a search beside noise alone."""
    if judgement.verdict != "explained":
        plain = found.baseline
        return _Conclusion(judgement.verdict, judgement.reason, plain, plain, plain, (), ())
    effects = tuple(_named(context, found.fit, name, one) for name, one in sure.items())
    return _Conclusion(
        "explained", judgement.reason, found.baseline, found.fit, found.baseline, effects, tuple(tried)
    )


def _beside(context: SearchContext, baseline: GapFit, beside: BesideDiscrepancy) -> _Conclusion:
    """Conclude from a search beside a discrepancy; where nothing is claimed, the gap is that of `baseline`."""
    return _Conclusion(
        "partly_explained" if beside.claimed else "unknown",
        beside.reason,
        beside.baseline if beside.claimed else baseline,
        beside.final if beside.claimed else baseline,
        beside.baseline,
        tuple(_named(context, beside.final, name, sure) for name, sure in beside.sure.items()),
        beside.tried,
        beside.found.scatter,
    )


def _searched(
    model: HeldEffects,
    updated: Updated,
    sweeps: GapSweeps,
    noise: NoiseCheck,
    executor: Executor,
    report: Progress,
    remade: Remade,
) -> tuple[SearchContext, SearchResult]:
    """Search, and again where an effect may replace a declared quantity that is beyond its tolerance.

    Most are so without any effect, which saves a search, but not where so much is missing that all of them bend.
    """
    context = SearchContext(model, sweeps, noise, executor, report)
    start = starting_state(updated, sweeps.groups)
    few, part = context.at_few_temperatures(start)
    begun = few.fit(part, ())
    released = None if few.far(begun) else _released(model, begun, remade)
    if released is None:
        found = stepwise_search(context, context.fit(context.spread(start, few, begun.state), ()))
        released = _released(model, found.fit, remade)
        if released is None:
            return context, found
    return _searched(released, updated, sweeps, noise, executor, report, remade)


def _released(model: HeldEffects, fit: GapFit, remade: Remade) -> HeldEffects | None:
    """Return the model without the tolerances that a fit exceeds and an effect replaces; None without such."""
    beyond = [one.name for one in fit.declared_quantities(model.tolerance_cards) if one.beyond]
    better = remade(fit.state.declared) if beyond else None
    found = (model if better is None else replace(model, twin=better)).releasing(beyond)
    return None if better is None and found.released == model.released else found


def _report(
    updated: Updated,
    context: SearchContext,
    found: SearchResult,
    conclusion: _Conclusion,
    alone: tuple[Signature, ...],
    notes: tuple[str, ...],
    seconds: float,
) -> GapReport:
    sweeps, noise, cards = context.sweeps, context.noise, context.model.tolerance_cards
    baseline, final, plain = conclusion.baseline, conclusion.final, conclusion.plain
    effects = conclusion.effects
    before = _laws(updated, sweeps, plain)
    gap = context.z(found.baseline) > Z_FLOOR
    left = float(np.clip(context.excess(final) / context.excess(baseline), 0.0, 1.0)) if gap else None
    return GapReport(
        verdict=conclusion.verdict,
        effects=tuple(sorted(effects, key=lambda e: -e.log_evidence_gain)),
        not_observable=tuple(o for o in found.seen if not o.observable),
        seen=found.seen,
        baseline=_agreement(context, baseline),
        final=_agreement(context, final),
        held_out=conclusion.held_out,
        unexplained=left,
        before=residual_map(sweeps, noise, baseline),
        after=residual_map(sweeps, noise, final),
        laws_before=before,
        laws_after=before if conclusion.verdict == "unknown" else _laws(updated, sweeps, final),
        plain=PlainTwin(plain.state, before, _sigma_gain(plain), plain.declared_quantities(cards)),
        state=final.state,
        sigma_gain=_sigma_gain(final),
        candidates=_candidates(context, found, effects[0].name if effects else None),
        signatures=alone,
        steps=found.steps,
        noise=noise,
        notes=notes,
        seconds=seconds,
        declared=conclusion.issued.declared_quantities(cards),
        titles={name: card.said for name, card in context.model.cards.items()},
        scatter=conclusion.scatter,
    )


def _agreement(context: SearchContext, fit: GapFit) -> Agreement:
    chi2, dof = context.sweeps.between
    return Agreement(
        chi2_per_dof=(fit.total + chi2) / (fit.dof + dof),
        relative_misfit=relative_misfit(context.sweeps, fit),
        z=context.z(fit),
        whiteness=whiteness(context.sweeps, fit.residual),
    )


def _laws(updated: Updated, sweeps: GapSweeps, fit: GapFit) -> FittedLaws:
    sheet = fitted_sheet(None if updated.sheet is None else updated.sheet.declared, fit)
    return replace(fit.fitted_laws(sweeps.groups.reference), sheet=sheet)


def _sigma_gain(fit: GapFit) -> Real:
    return np.asarray(np.exp(fit.state.log_gain) * fit.stated.log_gain)


def _surety(context: SearchContext, found: SearchResult, name: str) -> Surety:
    """Say how sure an effect is that brings the twin down to the noise, with others or alone."""
    fit, lost, overstated = found.fit, found.losses[name], context.overstated(found.fit)
    rivals = {other: gain / overstated for other, gain in found.rivals[name].items()}
    alike = equivalents(rivals, {other: signal_cosine(found.last, name, other) for other in rivals})
    gain = lost.gain / overstated
    others = against(gain, rivals, lost.unknown / overstated, fit.total / fit.dof)
    return Surety(gain, others, alike, probability(others, alike))


def _named(context: SearchContext, fit: GapFit, name: str, sure: Surety) -> NamedEffect:
    card, sigmas = context.model.cards[name], fit.stated.parameters
    estimates = [
        Estimate(parameter, fit.state.effects[name][parameter], float(sigma), p.unit)
        for (effect, parameter), p, sigma in zip(fit.free.names, fit.free.cards, sigmas, strict=True)
        if effect == name
    ]
    return NamedEffect(
        name=name,
        summary=card.summary,
        equivalent=sure.equivalent,
        separated_by=card.separated_by,
        probability=sure.probability,
        against=sure.against,
        log_evidence_gain=sure.gain,
        parameters=tuple(estimates),
        title=card.said,
        phrase=card.phrase,
        shown={p.name: p.shown for p in card.parameters if p.shown},
    )


def _candidates(context: SearchContext, found: SearchResult, first: str | None) -> tuple[CandidateRow, ...]:
    """Return the table of single effects at the baseline, largest predicted gain first, beside the one found."""
    candidates = found.first.candidates()
    fitted = {r.effects[0]: r for r in found.steps[0].refits if len(r.effects) == 1} if found.steps else {}
    kept = {o.effect: o.kept for o in found.seen}
    places = [(c.effects[0], found.first.columns[c.columns[0]].site) for c in candidates]
    table = tangent_cosines(found.first, places)
    names = [name for name, _ in places]
    winner = names.index(first) if first in names else None
    rows = []
    for place, c in enumerate(candidates):
        trial = fitted.get(c.effects[0])
        rows.append(
            CandidateRow(
                effect=c.effects[0],
                screened=c.gain / context.sweeps.overstated,
                fitted=trial.gain / context.sweeps.overstated if trial else None,
                share=min(trial.share, 1.0) if trial else None,  # of what is beyond the expected noise
                kept=kept[c.effects[0]],
                cosine=float(table[place, winner]) if winner is not None else 0.0,
            )
        )
    return tuple(rows)


def judge(context: SearchContext, found: SearchResult, tried: HeldOut | None) -> Judgement:
    """Decide whether named effects bring the twin down to the noise.

    Where none do, the verdict is unknown, and `analysis.gap.imperfect` may name effects beside what is left. An
    effect is accepted by the remaining residual here: beside noise alone, evidence grows with every effect that
    fits a little.

    Parameters
    ----------
    context : SearchContext
    found : SearchResult
    tried : HeldOut or None
        The split that decides; None where no effect was found.

    Returns
    -------
    Judgement
    """
    silent = context.agrees(found.baseline)
    if not found.effects or tried is None:
        if silent:
            return Judgement("none", "the twin agrees with the data to the noise, no effect adds to it")
        return Judgement("unknown", "there is a gap, and no effect of the library explains it")
    if not tried.holds:
        verdict: Verdict = "none" if silent else "unknown"
        return Judgement(verdict, f"what was found does not hold on data left out ({tried.what})")
    if context.agrees(found.fit) and not _leaves_structure(context, found.fit):
        return Judgement("explained", "with the effects named, twin and data agree to the noise")
    return Judgement("unknown", "with the best effects, more than noise is left")


def _leaves_structure(context: SearchContext, fit: GapFit) -> bool:
    """Whether the residual, beyond the twin's own error, has more evidence for a discrepancy than noise has."""
    if context.excess(fit) <= context.allowed(fit):
        return False
    least = noise_evidence(context.sweeps) * context.overstated(fit)
    return unknown_evidence(context.sweeps, fit.residual, fit.state) >= least


MOST_MAPPED = 12
"""Number of candidates that are mapped, for people to look at: each asks the twin for all sweeps."""


def signatures(context: SearchContext, found: SearchResult) -> tuple[Signature, ...]:
    """Map the residual of the baseline with each of the best effects alone, largest predicted gain first."""
    context.report("signatures", 0.0)
    fits = {r.effects[0]: r.fit for r in found.steps[0].refits if len(r.effects) == 1} if found.steps else {}
    candidates = found.first.candidates()[:MOST_MAPPED]
    screened = [c for c in candidates if fits.get(c.effects[0]) is None]
    left = dict(zip((c.effects[0] for c in screened), _first_order(context, found, screened), strict=True))
    left |= {name: fit.residual for name, fit in fits.items() if fit is not None}
    return tuple(
        Signature(name, cell_sigma(context.sweeps, context.noise, left[name]), fits.get(name) is not None)
        for name in (c.effects[0] for c in candidates)
    )


def _first_order(
    context: SearchContext, found: SearchResult, candidates: Sequence[Candidate]
) -> list[NDArray[np.complex128]]:
    """Residual (T, K, n) after the step of each candidate, with laws, readings and gain readjusted."""
    sweeps, state = context.sweeps, found.baseline.state
    columns = [found.first.columns[place] for c in candidates for place in c.columns]
    tangents: list[Tangent] = [
        (c.effect, c.card.name, context.model.cards[c.effect].zero(c.shapes)) for c in columns
    ]
    white = whiten_all(context.model, sweeps, state, tangents, context.executor)
    head = schur_complement(sweeps, [w.equations() for w in white], state)
    alone, gains = head.without_gains(), head.gains
    left, begin = [], gains
    for candidate in candidates:
        step = np.zeros(gains + len(columns))
        step[begin : begin + len(candidate.step)] = candidate.step
        step[:gains] = alone.covariance @ head.gradient[:gains] - alone.lever @ step[gains:]
        begin += len(candidate.step)
        own = head.columns @ head.follow(step)
        left.append(np.array([w.after(np.concatenate([mine, step])) for w, mine in zip(white, own, strict=True)]))
    return left
