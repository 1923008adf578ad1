"""What each candidate alone would leave, whether it was fitted or screened only."""

import numpy as np
import pytest

from analysis.gap.fitting.fit import fit_gap
from analysis.gap.fitting.residual_map import cell_sigma, residual_map
from analysis.gap.gap import signatures
from analysis.gap.search.context import SearchContext
from analysis.gap.search.stepwise import stepwise_search


@pytest.fixture(scope="module")
def compared(toy, pool):
    sweeps, noise = toy.prepared(temperatures=(10.0, 14.0, 18.0, 22.0, 26.0), effects={"mass": {"grams": 0.1}})
    context = SearchContext(toy.Plate(), sweeps, noise, pool)
    found = stepwise_search(context, fit_gap(context.model, sweeps, toy.start(sweeps.groups), (), pool))
    return context, found, {s.effect: s for s in signatures(context, found)}


def test_there_is_one_for_every_candidate(compared, toy):
    context, found, alone = compared
    assert set(alone) == set(toy.cards)
    assert alone["mass"].fitted
    assert not all(s.fitted for s in alone.values())
    assert found.effects == ("mass",)
    np.testing.assert_allclose(alone["mass"].sigma, residual_map(context.sweeps, context.noise, found.fit).sigma)


@pytest.mark.parametrize("name", ["stretch", "taper", "draught", "drift", "delay", "feedthrough"])
def test_to_first_order_it_is_what_a_fit_leaves(compared, pool, name):
    context, found, alone = compared
    start = found.baseline.state.with_effects({name: context.model.cards[name].zero()})
    fit = fit_gap(context.model, context.sweeps, start, (name,), pool)
    before = residual_map(context.sweeps, context.noise, found.baseline).sigma
    left = cell_sigma(context.sweeps, context.noise, fit.residual)
    moved = float(np.abs(left - before).max())
    np.testing.assert_allclose(alone[name].sigma, left, atol=0.08 * moved + 2e-3)
