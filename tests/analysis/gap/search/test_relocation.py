"""A spot that a fit left at the wrong place is found again beside another effect."""

from dataclasses import replace

import numpy as np
import pytest

from analysis.gap.data.preparation import prepare
from analysis.gap.fitting.fit import fit_gap
from analysis.gap.fitting.state import starting_state
from analysis.gap.search.context import SearchContext
from analysis.gap.search.relocation import relocated

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
