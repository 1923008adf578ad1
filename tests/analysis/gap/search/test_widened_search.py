"""Fits of effects that move resonances far begin near the solution, and with the right effect first."""

import numpy as np
import pytest

from analysis.gap.data.preparation import prepare
from analysis.gap.fitting.state import starting_state
from analysis.gap.search import stepwise
from analysis.gap.search.context import SearchContext
from analysis.gap.search.stepwise import widened_starts

FEW = (5.0, 20.0, 35.0, 50.0)


@pytest.fixture
def begun(toy, pool):
    """Return a function: effects of the world -> context and fit without effects."""

    def begin(effects, **others):
        frf, protocol = toy.record(effects=effects, temperatures=FEW, **others)
        updated = toy.updated(frf)
        sweeps, noise = prepare(frf, protocol, updated)
        context = SearchContext(toy.Plate(), sweeps, noise, pool)
        return context, context.fit(starting_state(updated, sweeps.groups), ())

    return begin


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("mass", {"grams": 9.0}),
        ("damage", {"loss": 0.4, "x": 0.21}),
        ("stretch", {"delta_e": 0.2, "delta_g": -0.1}),
    ],
)
def test_the_right_effect_is_first_and_its_fit_begins_near_it(begun, name, values):
    context, fit = begun({name: values})
    assert context.far(fit)
    first = widened_starts(context, fit, ())[0]
    assert first.effects == (name,)
    for parameter, value in values.items():
        assert first.state.effects[name][parameter] == pytest.approx(value, rel=0.1)


def test_near_the_data_and_at_part_of_the_lines_there_is_none(begun):
    context, fit = begun({"mass": {"grams": 0.05}})
    assert not context.far(fit)
    assert widened_starts(context, fit, ()) is None
    context, fit = begun({"mass": {"grams": 9.0}})
    half = np.arange(context.sweeps.rows.shape[-1]) % 2 == 0
    part = context.of(context.sweeps.masked(half))
    assert part.far(fit)
    assert widened_starts(part, fit, ()) is None


def test_effects_that_the_data_do_not_show_are_left_out(begun):
    context, fit = begun({"mass": {"grams": 9.0}})
    assert all("mass" not in one.effects for one in widened_starts(context, fit, ("mass",)))


@pytest.mark.parametrize(
    ("name", "values", "widens"), [("mass", {"grams": 1.0}, False), ("damage", {"loss": 0.4, "x": 0.21}, True)]
)
def test_the_search_widens_only_what_first_order_does_not_foresee(begun, monkeypatch, name, values, widens):
    """Both are far from noise; the mass hardly moves resonances, so that derivatives tell its size."""
    context, fit = begun({name: values})
    assert context.far(fit)
    asked = []
    monkeypatch.setattr(stepwise, "widened_starts", lambda *given: asked.append(given) or widened_starts(*given))
    found = stepwise.stepwise_search(context, fit)
    assert found.effects == (name,)
    for parameter, value in values.items():
        assert found.fit.state.effects[name][parameter] == pytest.approx(value, rel=0.02)
    assert bool(asked) == widens


def test_fits_that_take_no_share_are_given_up(begun, monkeypatch):
    """Without the cause, fits to a few per cent were followed to their end, each for 15 linearisations."""
    context, fit = begun({"damage": {"loss": 0.4, "x": 0.21}})
    passes = {}
    fitted = stepwise._fitted

    def counted(wide, start, effects, *enough):
        found = fitted(wide, start, effects, *enough)
        passes[tuple(effects)] = found.passes
        return found

    monkeypatch.setattr(stepwise, "_fitted", counted)
    left = ("delay", "softening")
    assert widened_starts(context, fit, [name for name in context.model.cards if name not in left]) == []
    assert max(passes[name,] for name in left) <= 2
    monkeypatch.setattr(stepwise, "widened_starts", lambda *given: [])
    found = stepwise.stepwise_search(context, fit)
    assert found.effects == ()
    assert [step.refits for step in found.steps] == [()]
