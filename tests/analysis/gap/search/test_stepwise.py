"""Several strong effects are found from far: at a few temperatures until all are there, then at all."""

import numpy as np
import pytest

import analysis.gap.search.context as search_context
from analysis.gap.data.preparation import prepare
from analysis.gap.fitting.fit import fit_gap
from analysis.gap.fitting.state import starting_state
from analysis.gap.gap import find_gap
from analysis.gap.search.context import SearchContext
from analysis.gap.search.drop_and_swap import dropped
from analysis.gap.search.stepwise import stepwise_search

TRUE = {"mass": {"grams": 5.0}, "lag": {"tau": 600.0}}


@pytest.fixture(scope="module")
def searched(toy, pool):
    """Return the context, the result of the search, and its fits as (number of sweeps, effects), in order."""
    frf, protocol = toy.record(effects=TRUE, temperatures=tuple(np.arange(2.0, 59.0, 4.0)))
    updated = toy.updated(frf)
    sweeps, noise = prepare(frf, protocol, updated)
    context = SearchContext(toy.Plate(), sweeps, noise, pool)
    start = starting_state(updated, sweeps.groups)
    few, part = context.at_few_temperatures(start)
    begun = few.fit(part, ())
    baseline = context.fit(context.spread(start, few, begun.state), ())
    fits, fit_gap = [], search_context.fit_gap

    def watched(model, sweeps, start, effects, executor, **others):
        fits.append((sweeps.count, frozenset(effects)))
        return fit_gap(model, sweeps, start, effects, executor, **others)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(search_context, "fit_gap", watched)
        found = stepwise_search(context, baseline)
    return context, baseline, found, fits


def test_both_are_found_and_leave_noise(searched):
    context, baseline, found, _ = searched
    assert context.far(baseline)
    assert set(found.effects) == set(TRUE)
    assert context.agrees(found.fit)
    for name, values in TRUE.items():
        for parameter, value in values.items():
            place = found.fit.free.names.index((name, parameter))
            away = found.fit.state.effects[name][parameter] - value
            assert abs(away) < 4.0 * found.fit.noise.parameters[place]


def test_all_sweeps_are_fitted_once_both_are_known(searched):
    context, _, _, fits = searched
    of_all = [effects for count, effects in fits if count == context.sweeps.count]
    assert of_all[0] == frozenset(TRUE)


def test_what_a_few_temperatures_told_stands_for_all(searched):
    context, baseline, found, _ = searched
    first = found.steps[0]
    best = first.refits[0]
    assert first.accepted
    assert best.fit is None  # fitted to a few only
    assert 0.5 < best.share <= 1.0
    # fitted to all sweeps, the evidence of the first effect alone is what was estimated, and so is its loss
    (other,) = set(TRUE) - set(best.effects)
    alone = dropped(context, baseline, found.fit, other)
    assert best.gain == pytest.approx(alone.log_evidence - baseline.log_evidence, rel=0.1)
    assert found.losses[other].gain == pytest.approx(found.fit.log_evidence - alone.log_evidence, rel=0.2)


def test_what_is_left_without_an_effect_is_fitted_from_there_too(searched):
    """The fit of one effect before the other was there may have ended anywhere."""
    context, baseline, found, _ = searched
    first, second = TRUE
    again = context.of(context.sweeps)
    start = baseline.state.with_effects({first: context.model.cards[first].zero()})
    poor = fit_gap(context.model, context.sweeps, start, (first,), context.executor, target=np.inf)
    again.fits.keep((first,), poor)
    better = again.fit_without(found.fit.state, second)
    assert better.log_evidence > poor.log_evidence + 1.0
    assert again.fits.known((first,)) is better
    assert again.fit_without(found.fit.state, second) is better  # not made a third time


@pytest.mark.parametrize(
    "true",
    [
        # the second that is taken stands for two others, and leaves again once these are there
        pytest.param(
            {"mass": {"grams": 5.0}, "lag": {"tau": 600.0}, "taper": {"tx": 0.05}, "delay": {"seconds": 3e-5}},
            marks=pytest.mark.slow,
            id="four",
        ),
        pytest.param(
            {
                "mass": {"grams": 2.0},
                "drift": {"alpha": 0.004},
                "draught": {"gx": 4.0},
                "delay": {"seconds": 1e-5},
                "feedthrough": {"gain": 0.02},
            },
            id="five",
        ),
    ],
)
def test_more_than_three_are_told_apart(toy, pool, true):
    frf, protocol = toy.record(effects=true, temperatures=tuple(np.arange(2.0, 59.0, 4.0)))
    report = find_gap(frf, toy.updated(frf), toy.Plate(), protocol, pool)
    # the fit of four to all temperatures creeps along the lag against the readings, and ends 8 % above the noise
    assert report.verdict == "explained" or (report.verdict == "partly_explained" and "lag" in true)
    assert {effect.name for effect in report.effects} == set(true)
    for effect in report.effects:
        for one in effect.parameters:
            assert abs(one.value - true[effect.name][one.name]) < 4.0 * one.sigma
            assert one.sigma < 0.05 * abs(one.value)
