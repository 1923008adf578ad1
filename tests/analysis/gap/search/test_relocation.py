"""A spot that a fit left at the wrong place is found again beside another effect."""

from dataclasses import replace

import numpy as np
import pytest

from analysis.effect_card import EffectCard, Parameter
from analysis.gap.data.preparation import prepare
from analysis.gap.fitting.fit import fit_gap
from analysis.gap.fitting.state import starting_state
from analysis.gap.search.context import SearchContext
from analysis.gap.search.stepwise import best_image, relocated

TRUE = {"damage": {"loss": 0.3, "x": 0.33}, "stretch": {"delta_e": 0.02, "delta_g": -0.01}}


@pytest.fixture(scope="module")
def context(toy, pool):
    frf, protocol = toy.record(effects=TRUE, temperatures=tuple(np.arange(2.0, 39.0, 4.0)))
    updated = toy.updated(frf)
    sweeps, noise = prepare(frf, protocol, updated)
    context = SearchContext(toy.Plate(2), sweeps, noise, pool)
    return context, context.fit(starting_state(updated, sweeps.groups), ())


def fitted(context, baseline, x):
    """Both effects, the spot's fit begun at x and with the loss that was put in."""
    start = replace(baseline.state, effects={**TRUE, "damage": {"loss": 0.3, "x": x}})
    return fit_gap(context.model, context.sweeps, start, tuple(TRUE), context.executor)


def test_a_spot_at_the_wrong_place_is_put_where_it_is(context):
    context, baseline = context
    wrong = max((fitted(context, baseline, x) for x in (0.06, 0.14, 0.46)), key=lambda fit: -fit.log_evidence)
    assert abs(wrong.state.effects["damage"]["x"] - 0.33) > 0.05
    found = relocated(context, baseline, wrong)
    assert found.state.effects["damage"]["x"] == pytest.approx(0.33, abs=0.01)
    assert context.agrees(found)
    assert context.fits.known(TRUE) is found


def test_a_spot_at_the_right_place_stays(context):
    context, baseline = context
    right = fitted(context, baseline, 0.33)
    moved = relocated(context, baseline, right)
    assert moved.log_evidence == pytest.approx(right.log_evidence, abs=0.1)


GRID = np.arange(0.1, 0.95, 0.1)
SPOT = EffectCard(
    "spot",
    "mass on a symmetrical plate",
    (
        Parameter("grams", "g", 0.0, 10.0, 1.0),
        Parameter("x", "1", 0.05, 0.95, 0.3, shape=True, typical=0.5),
        Parameter("y", "1", 0.05, 0.95, 0.3, shape=True, typical=0.5),
    ),
    "nothing",
    "nothing",
    tuple({"x": x, "y": y} for x in GRID for y in GRID),
)


CARDS = {"spot": SPOT, "second_spot": replace(SPOT, name="second_spot", after="spot")}


def test_a_fit_at_the_mirror_image_of_a_place_is_put_where_it_belongs(toy, pool):
    plate = toy.placed(CARDS)
    true = {"grams": 3.0, "x": 0.7, "y": 0.3}
    frf, protocol = toy.record(effects={"spot": true}, temperatures=(18.0, 26.0, 34.0), plate=plate)
    updated = toy.updated(frf)
    sweeps, noise = prepare(frf, protocol, updated)
    context = SearchContext(plate, sweeps, noise, pool)
    start = starting_state(updated, sweeps.groups)
    for x, y in ((0.3, 0.7), (0.3, 0.3), (0.7, 0.7)):
        began = replace(start, effects={"spot": {"grams": 3.0, "x": x, "y": y}})
        wrong = fit_gap(plate, sweeps, began, ("spot",), pool)
        assert wrong.state.effects["spot"]["x"] == pytest.approx(x, abs=0.1)
        assert not context.agrees(wrong)
        found = best_image(context, wrong, "spot")
        assert [found.state.effects["spot"][axis] for axis in "xy"] == pytest.approx([0.7, 0.3], abs=0.01)
        assert context.agrees(found)
        assert best_image(context, found, "spot") is found


def test_each_of_two_alike_is_tried_elsewhere(toy, pool):
    """Without the first, the second takes its name, and is what is missing then; that ended with a traceback."""
    plate = toy.placed(CARDS)
    first, second = {"grams": 3.0, "x": 0.7, "y": 0.3}, {"grams": 2.0, "x": 0.2, "y": 0.5}
    true = {"spot": first, "second_spot": second}
    frf, protocol = toy.record(effects=true, temperatures=(18.0, 26.0, 34.0), plate=plate)
    updated = toy.updated(frf)
    sweeps, noise = prepare(frf, protocol, updated)
    context = SearchContext(plate, sweeps, noise, pool)
    baseline = context.fit(starting_state(updated, sweeps.groups), ())
    began = replace(baseline.state, effects={"spot": first, "second_spot": {"grams": 2.0, "x": 0.8, "y": 0.5}})
    wrong = fit_gap(plate, sweeps, began, tuple(true), pool)
    assert not context.agrees(wrong)
    found = relocated(context, baseline, wrong)
    assert set(found.state.effects) == set(true)
    assert found.log_evidence >= wrong.log_evidence
