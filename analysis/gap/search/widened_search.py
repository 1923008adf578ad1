"""Where fits begin of effects that move resonances by more than their widths.

There derivatives at the present twin tell neither how large an effect is nor which one it is: fits end beside the
solution. Over wider resonances (`analysis.gap.data.widened`) they do, and each candidate is fitted to these first,
with declared quantities as declared, because they would only follow what is missing.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from analysis.gap.data.widened import widened
from analysis.gap.fitting.fit import fit_gap
from analysis.gap.fitting.gap_fit import GapFit
from analysis.gap.fitting.state import GapState
from analysis.gap.search.candidate import Candidate
from analysis.gap.search.context import SearchContext
from analysis.gap.search.refit import absent
from analysis.gap.search.score_test import score_test
from analysis.gap.thresholds import (
    BEHIND,
    LEAVES_NOISE,
    MOVED_ELSEWHERE,
    REFITTED,
    SITES_REFITTED,
    WIDENED,
    WIDENED_ERROR,
)


@dataclass(frozen=True)
class WidenedStart:
    """A candidate, and where its fit begins.

    Attributes
    ----------
    candidate : Candidate
        As screened over wider resonances.
    effects : tuple of str
        Those that are on, and the candidate's.
    state : GapState
        That fits wider resonances best.
    left : float
        Objective there.
    """

    candidate: Candidate
    effects: tuple[str, ...]
    state: GapState
    left: float


def widened_starts(context: SearchContext, fit: GapFit, blind: Sequence[str]) -> list[WidenedStart]:
    """Return where fits of the best candidates begin, the best first; an empty list where none helps.

    None does near the data, where derivatives there tell more, nor at part of the lines, which wider resonances
    would not keep apart from the others.

    Parameters
    ----------
    context : SearchContext
        Of the sweeps of `fit`.
    fit : GapFit
        Which candidates are added to.
    blind : sequence of str
        Effects that these data do not show.
    """
    if not context.far(fit) or not context.few or not context.sweeps.rows.all():
        return []
    wide = context.of(widened(context.sweeps, WIDENED, WIDENED_ERROR))
    on = tuple(fit.state.effects)
    held = fit.state if fit.held is None else fit.held.state
    begun = _fitted(wide, replace(held, declared={}).with_tolerances(context.model.tolerance_cards), on)
    screening = score_test(context.model, wide.sweeps, begun, context.executor)
    worth = [c for c in screening.candidates() if c.effects[0] not in blind and c.gain > 0.0][:REFITTED]

    def begin(candidate: Candidate) -> WidenedStart:
        names = (*on, *candidate.effects)
        start = begun.state.with_effects({**begun.state.effects, **absent(context, screening, candidate)})
        there = _fitted(wide, start, names)
        return WidenedStart(candidate, names, there.state, there.objective)

    found = []
    for place, candidate in enumerate(worth):
        found.append(begin(candidate))
        context.report("wider resonances", (place + 1) / len(worth))
    found.sort(key=lambda one: one.left)
    enough = LEAVES_NOISE * wide.sweeps.numbers
    for place, one in enumerate(found[:MOVED_ELSEWHERE]):
        sites = sorted(screening.at_sites(one.candidate.effects[0]), key=lambda c: -c.gain)[:SITES_REFITTED]
        for candidate in sites[1:]:
            if min(known.left for known in found) > enough:
                found[place] = min(found[place], begin(candidate), key=lambda known: known.left)
    found.sort(key=lambda one: one.left)
    return [one for one in found if one.left <= BEHIND * found[0].left and one.left < begun.objective]


def _fitted(wide: SearchContext, start: GapState, effects: Sequence[str]) -> GapFit:
    return fit_gap(
        wide.model, wide.sweeps, start, effects, wide.executor, target=wide.settled, declared_free=False
    )
