"""Signatures: the residual that each candidate alone would leave, cell by cell."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.gap.fitting.normal_equations import whiten_all
from analysis.gap.fitting.residual_map import Signature, cell_sigma
from analysis.gap.fitting.schur_complement import schur_complement
from analysis.gap.search.candidate import Candidate
from analysis.gap.search.context import SearchContext
from analysis.gap.search.stepwise import SearchResult
from analysis.twin_model import Tangent

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
