"""Relocation: an effect with a place is fitted again from other sites, beside the other effects found."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from analysis.effect_card import EffectCard, Values
from analysis.gap.fitting.gap_fit import GapFit
from analysis.gap.search.context import SearchContext
from analysis.gap.search.drop_and_swap import dropped
from analysis.gap.search.refit import absent, at_few_temperatures, started_from
from analysis.gap.search.score_test import score_test
from analysis.gap.thresholds import NEAR_MARGIN, SITES_REFITTED


def relocated(context: SearchContext, baseline: GapFit, fit: GapFit) -> GapFit:
    """Fit every effect that has several sites again from the best of them, and return the best fit.

    The first effect of several is placed while the signal of the others is still in the residual. A fit moves it
    to the nearest maximum of the evidence only, which may be another place than that of the effect.

    Parameters
    ----------
    context : SearchContext
    baseline : GapFit
        Without effects.
    fit : GapFit
        With the effects found.

    Returns
    -------
    GapFit
        `fit` where no other place is better.
    """
    for name in fit.state.effects:
        if len(context.model.cards[name].sites) > 1:
            fit = _placed_again(context, fit, dropped(context, baseline, fit, name), name)
    return fit


def _placed_again(context: SearchContext, fit: GapFit, rest: GapFit, name: str) -> GapFit:
    """Return the best of `fit` and of fits from other sites of an effect that `rest` lacks."""
    on = tuple(fit.state.effects)
    contest = score_test(context.model, context.sweeps, rest, context.executor, effects=(name,))
    sites = sorted(contest.at_sites(name), key=lambda c: -c.gain)[:SITES_REFITTED]
    few, reference = at_few_temperatures(context, rest)
    best = None
    for site in sites:
        start = started_from(reference, on, absent(context, contest, site))
        enough = -2.0 * best.log_evidence if best else float("inf")
        trial = few.fit_from(start, on, enough=enough)
        best = trial if best is None or trial.log_evidence > best.log_evidence else best
    if best is None:
        return fit
    seen = best
    if few is not context:
        start = rest.state.corrected(context.sweeps, reference.state, best.state, few.sweeps)
        best = context.fit_from(start, on)
    if best.log_evidence <= fit.log_evidence:
        return fit
    few.fits.keep(on, seen)
    context.fits.keep(on, best)
    return best


NEIGHBOUR = 1.5
"""Distances between neighbouring sites up to which an image is on the plate: the sites fill the plate."""


def best_image(context: SearchContext, fit: GapFit, name: str) -> GapFit:
    """Fit an effect with a place again from the mirror images of that place, and return the best fit.

    On a symmetrical plate whatever stands at an image of a place shifts every resonance as much as there. Far
    from the data, where resonances are shifted by more than their widths, the screen sees little else, and a fit
    settles at the nearest image, although the shapes contradict it.

    Parameters
    ----------
    context : SearchContext
    fit : GapFit
        With the effect.
    name : str
        Of the effect.

    Returns
    -------
    GapFit
        `fit` where it agrees with the data, and where no image is better.
    """
    on = tuple(fit.state.effects)
    places = [] if context.agrees(fit) else list(_images(context.model.cards[name], fit.state.effects[name]))
    if not places:
        return fit
    few, reference = at_few_temperatures(context, fit)
    best = reference
    for place in places:
        start = replace(reference.state, effects={**reference.state.effects, name: place})
        enough = -2.0 * best.log_evidence
        try:
            trial = few.fit_from(start, on, target=few.settled, enough=enough, margin=NEAR_MARGIN)
        except ValueError:  # an image off the plate, in a notch of its outline
            continue
        best = trial if trial.settled and trial.log_evidence > best.log_evidence else best
    if best is reference:
        return fit
    few.fits.keep(on, best)
    if few is context:
        return best
    start = fit.state.corrected(context.sweeps, reference.state, best.state, few.sweeps)
    full = context.fit_from(start, on, target=context.settled)
    if full.log_evidence <= fit.log_evidence:
        return fit
    context.fits.keep(on, full)
    return full


def _images(card: EffectCard, values: Values) -> Iterator[dict[str, float]]:
    """Yield an effect's values with its place reflected in the middle lines of the plate."""
    if len(card.sites) < 2 or not {"x", "y"} <= set(card.sites[0]):
        return
    sites = np.array([[site["x"], site["y"]] for site in card.sites])
    spacing = np.median([np.partition(np.hypot(*(sites - one).T), 1)[1] for one in sites])
    turned = sites.min(axis=0) + sites.max(axis=0) - np.array([values["x"], values["y"]])
    for x, y in ((turned[0], values["y"]), (values["x"], turned[1]), (turned[0], turned[1])):
        if np.hypot(*(sites - (x, y)).T).min() <= NEIGHBOUR * spacing:
            yield {**values, "x": float(x), "y": float(y)}
