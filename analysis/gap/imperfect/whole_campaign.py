"""Twins found beside a discrepancy at a few temperatures, fitted to all sweeps."""

from dataclasses import replace

import numpy as np

from analysis.arrays import Complex
from analysis.gap.data.line_weights import LineWeights
from analysis.gap.fitting.gap_fit import GapFit, Uncertainty
from analysis.gap.fitting.normal_equations import WhitenedSweep, whiten_all
from analysis.gap.fitting.schur_complement import SchurComplement, schur_complement
from analysis.gap.fitting.state import GapState
from analysis.gap.imperfect.discrepancy import DiscrepancyShape
from analysis.gap.imperfect.search import Imperfect, settled_to_first_order
from analysis.gap.search.context import SearchContext
from analysis.gap.search.refit import at_few_temperatures
from analysis.twin_model import Tangent


def over_all_sweeps(context: SearchContext, baseline: GapFit, few: Imperfect) -> GapFit:
    """Fit a twin to all sweeps beside the scatter that it leaves at a few temperatures.

    Parameters
    ----------
    context : SearchContext
        Of all sweeps, unweighted.
    baseline : GapFit
        To these, without effects.
    few : Imperfect
        The twin with the effects found, at a few temperatures.

    Returns
    -------
    GapFit
        Its residual and chi2 are in units of the noise; its standard deviations contain the discrepancy.
    """
    if few.context.sweeps.count == context.sweeps.count:
        return _stated(context, few.shape, few, few.fit)
    groups, kept = context.sweeps.groups, context.coarse_groups
    places = few.context.sweeps.original_places(context.sweeps)
    begun = baseline.state.restricted(kept, places)
    state = baseline.state.corrected(groups, begun, few.fit.state, few.context.sweeps.groups)
    return _fitted(context, few, state, baseline.predicted)


def beside_scatter(context: SearchContext, fit: GapFit) -> GapFit:
    """Fit a twin again beside the scatter of resonances that it leaves, found at a few temperatures.

    Parameters
    ----------
    context : SearchContext
        Unweighted.
    fit : GapFit
        Beside noise alone.

    Returns
    -------
    GapFit
        As of `over_all_sweeps`.
    """
    sweeps, begun = at_few_temperatures(context, fit)
    found = settled_to_first_order(context.of(sweeps), begun)
    return _fitted(context, found, fit.state, fit.predicted)


def _fitted(context: SearchContext, few: Imperfect, state: GapState, predicted: Complex) -> GapFit:
    """Fit all sweeps beside the scatter of a few."""
    shape = DiscrepancyShape.of(context.sweeps, predicted, context.loss_factors(state))
    fit = context.weighted(shape.weights(few.scatter)).fit(state, few.effects)
    shape = DiscrepancyShape.of(context.sweeps, fit.predicted, context.loss_factors(fit.state))
    return _stated(context, shape, few, fit)


def _stated(context: SearchContext, shape: DiscrepancyShape, few: Imperfect, fit: GapFit) -> GapFit:
    """State a fit in units of the noise, with standard deviations that contain the discrepancy.

    Laws belong to one temperature each, and share its error with the other lines and channels only; what is common
    to the campaign shares it with all sweeps. The part of the laws' error that is not noise is common to all
    temperatures.
    """
    tangents: list[Tangent] = [(name, parameter, fit.state.on[name]) for name, parameter in fit.free.names]
    white = whiten_all(context.model, context.sweeps, fit.state, tangents, context.executor)
    residual = np.array([w.white[-1] for w in white])
    noise = Uncertainty.of(_head(context, white, fit, LineWeights.equal(residual.shape)), fit.free, True)
    together = Uncertainty.of(_head(context, white, fit, shape.weights(few.scatter)), fit.free, True)
    single = shape.within_a_sweep(context.sweeps).weights(few.scatter)
    alone = Uncertainty.of(_head(context, white, fit, single), fit.free, True).alone
    laws = np.sqrt(together.laws**2 - together.alone**2 + alone**2)
    ratio = laws / together.laws
    return replace(
        fit,
        noise=noise,
        stated=replace(
            together,
            laws=laws,
            alone=noise.alone,
            within=together.within * ratio[:, :, None] * ratio[:, None, :],
            across=together.across * ratio[:, :, None],
        ),
        chi2=(np.abs(residual) ** 2).sum(-1),
        residual=residual,
        predicted=np.array([w.predicted for w in white]),
    )


def _head(
    context: SearchContext, white: list[WhitenedSweep], fit: GapFit, weights: LineWeights
) -> SchurComplement:
    """Form the normal equations of all sweeps with weights."""
    equations = [
        WhitenedSweep(weights.weigh(w.white, sweep), w.predicted).equations() for sweep, w in enumerate(white)
    ]
    return schur_complement(context.sweeps, equations, fit.state)
