"""A campaign linearised once stands in for the twin near that state."""

from dataclasses import replace

import numpy as np
import pytest

from analysis.gap.fitting.fit import fit_gap
from analysis.gap.fitting.linearised_sweeps import LinearisedSweeps
from analysis.gap.fitting.normal_equations import linearise_all
from analysis.gap.fitting.state import starting_state
from analysis.gap.search.score_test import score_test


@pytest.fixture(scope="module")
def near(toy, pool):
    frf, _ = toy.record({"mass": {"grams": 0.1}}, temperatures=(10.0, 20.0, 30.0), directions=("up",), spacing=2.0)
    sweeps = toy.prepared(
        temperatures=(10.0, 20.0, 30.0), directions=("up",), spacing=2.0, effects={"mass": {"grams": 0.1}}
    )[0]
    model = toy.Plate(2)
    fit = fit_gap(model, sweeps, starting_state(toy.updated(frf), sweeps.groups), (), pool)
    return model, sweeps, fit, LinearisedSweeps.of(model, sweeps, fit.state, pool)


def test_where_it_is_made_it_is_the_twin(near, pool):
    model, sweeps, fit, linear = near
    tangents = [
        ("mass", "grams", {"grams": 0.0}),
        ("damage", "loss", {"loss": 0.0, "x": model.cards["damage"].sites[3]["x"]}),
    ]
    for one, other in zip(
        linearise_all(linear, sweeps, fit.state, tangents, pool),
        linearise_all(model, sweeps, fit.state, tangents, pool),
        strict=True,
    ):
        assert one.residual == pytest.approx(other.residual)
        assert one.matrix == pytest.approx(other.matrix, rel=1e-6, abs=1e-6 * np.abs(other.matrix).max())


def test_a_small_step_changes_the_residual_as_the_twin_does(near, pool):
    model, sweeps, fit, linear = near
    state = replace(
        fit.state,
        laws=fit.state.laws + 1e-5 * np.array([1.0, 0.3, 2.0]),
        away=fit.state.away + 1e-3,
        log_gain=fit.state.log_gain + 1e-5,
        effects={"mass": {"grams": 1e-3}},
    )
    before = np.array([e.residual for e in linearise_all(model, sweeps, fit.state, (), pool)])
    exact = np.array([e.residual for e in linearise_all(model, sweeps, state, (), pool)])
    found = np.array([e.residual for e in linearise_all(linear, sweeps, state, (), pool)])
    assert np.linalg.norm(found - exact) < 0.02 * np.linalg.norm(exact - before)


def test_fits_and_score_tests_on_it_are_those_of_the_twin(near, pool):
    model, sweeps, fit, linear = near
    start = fit.state.with_effects({"mass": {"grams": 0.0}})
    one, other = (fit_gap(m, sweeps, start, ("mass",), pool) for m in (linear, model))
    assert one.log_evidence == pytest.approx(other.log_evidence, abs=1.0)
    assert one.state.effects["mass"]["grams"] == pytest.approx(other.state.effects["mass"]["grams"], rel=0.02)
    tests = [score_test(m, sweeps, fit, pool) for m in (linear, model)]
    gains = [{c.effects: c.gain for c in test.candidates()} for test in tests]
    assert gains[0] == pytest.approx(gains[1], rel=1e-3, abs=0.1)


def test_shapes_of_an_effect_that_was_off_are_held_where_it_is_placed(near, pool):
    model, sweeps, fit, linear = near
    site = dict(model.cards["damage"].sites[2])
    start = fit.state.with_effects({"damage": model.cards["damage"].zero(site)})
    found = fit_gap(linear.placed({"damage": site}), sweeps, start, ("damage",), pool)
    assert found.state.effects["damage"]["x"] == pytest.approx(site["x"], abs=1e-6)
