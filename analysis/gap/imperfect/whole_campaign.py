"""Twins found beside a discrepancy at a few temperatures, fitted to all sweeps."""

from dataclasses import replace

import numpy as np

from analysis.gap.data.line_weights import LineWeights
from analysis.gap.fitting.fit import fit_gap
from analysis.gap.fitting.gap_fit import GapFit, Uncertainty
from analysis.gap.fitting.normal_equations import WhitenedSweep, whiten_all
from analysis.gap.fitting.schur_complement import SchurComplement, schur_complement
from analysis.gap.fitting.state import GapState
from analysis.gap.imperfect.discrepancy import DiscrepancyShape
from analysis.gap.imperfect.search import Imperfect
from analysis.gap.search.context import SearchContext
from analysis.twin_model import Tangent


def over_all_sweeps(context: SearchContext, start: GapState, few: Imperfect) -> GapFit:
    """Fit a twin to all sweeps beside the scatter that it leaves at a few temperatures.

    What is common to all temperatures (gains, effects, declared quantities) is held as found at these: beside a
    discrepancy that all sweeps share, further ones tell no more of it.

    Parameters
    ----------
    context : SearchContext
        Of all sweeps, unweighted.
    start : GapState
        Of these, from whose part the fits to a few temperatures began.
    few : Imperfect
        The twin with the effects found, at a few temperatures.

    Returns
    -------
    GapFit
        Its residual and chi2 are in units of the noise; its standard deviations contain the discrepancy.
    """
    if few.context.sweeps.count == context.sweeps.count:
        return _stated(context, few.shape, few, few.fit)
    state = context.spread(start, few.context, few.fit.state)
    white = whiten_all(context.model, context.sweeps, state, (), context.executor)
    shape = DiscrepancyShape.of(
        context.sweeps, np.array([w.predicted for w in white]), context.loss_factors(state)
    )
    sweeps = replace(context.sweeps, weights=shape.weights(few.scatter))
    fit = fit_gap(context.model, sweeps, state, (), context.executor, gain_free=False)
    shape = DiscrepancyShape.of(context.sweeps, fit.predicted, context.loss_factors(fit.state))
    return _stated(context, shape, few, fit)


def _stated(context: SearchContext, shape: DiscrepancyShape, few: Imperfect, fit: GapFit) -> GapFit:
    """State a fit in units of the noise, with standard deviations that contain the discrepancy.

    Laws belong to one temperature each, and share its error with the other lines and channels only; what is common
    to the campaign shares it with all sweeps. The part of the laws' error that is not noise is common to all
    temperatures.
    """
    free = few.fit.free
    tangents: list[Tangent] = [(name, parameter, fit.state.on[name]) for name, parameter in free.names]
    white = whiten_all(context.model, context.sweeps, fit.state, tangents, context.executor)
    residual = np.array([w.white[-1] for w in white])
    noise = Uncertainty.of(_head(context, white, fit, LineWeights.equal(residual.shape)), free, True)
    weighted = _head(context, white, fit, shape.weights(few.scatter))
    together = Uncertainty.of(weighted, free, True)
    single = shape.within_a_sweep(context.sweeps).weights(few.scatter)
    alone = Uncertainty.of(_head(context, white, fit, single), free, True).alone
    laws = np.sqrt(together.laws**2 - together.alone**2 + alone**2)
    ratio = laws / together.laws
    return replace(
        fit,
        free=free,
        information=weighted.without_gains().matrix,
        prior=few.fit.prior,
        declared=few.fit.declared,
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
