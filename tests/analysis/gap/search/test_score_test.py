"""One pass predicts what a full fit of each candidate would bring."""

from itertools import product

import numpy as np
import pytest

from analysis.gap.fitting.fit import fit_gap
from analysis.gap.search.candidate import solve_inside
from analysis.gap.search.confounding import signal_cosine, tangent_cosines
from analysis.gap.search.observability import observability
from analysis.gap.search.score_test import score_test

TEMPERATURES = (10.0, 14.0, 18.0, 22.0, 26.0)


def screened(toy, pool, **kwargs):
    sweeps, _ = toy.prepared(temperatures=kwargs.pop("temperatures", TEMPERATURES), **kwargs)
    plate = toy.Plate()
    fit = fit_gap(plate, sweeps, toy.start(sweeps.groups), (), pool)
    return plate, sweeps, fit, score_test(plate, sweeps, fit, pool)


@pytest.mark.parametrize(
    "effects",
    [{"mass": {"grams": 0.02}}, {"feedthrough": {"gain": 1e-5}}, {"stretch": {"delta_e": 2e-4, "delta_g": 0.0}}],
    ids=lambda e: next(iter(e)),
)
def test_evidence_of_the_screen_is_that_of_the_full_fit(toy, pool, effects):
    plate, sweeps, base, screening = screened(toy, pool, effects=effects)
    name = next(iter(effects))
    best = screening.candidates()[0]
    assert best.effects == (name,)
    full = fit_gap(plate, sweeps, base.state.with_effects({name: toy.cards[name].zero()}), (name,), pool)
    assert best.gain == pytest.approx(full.log_evidence - base.log_evidence, rel=0.03)
    for step, value in zip(best.step, full.free.read(full.state.effects), strict=True):
        assert step == pytest.approx(value, abs=0.05 * max(abs(v) for v in best.step))


def test_a_position_is_found_on_its_grid(toy, pool):
    *_, screening = screened(toy, pool, effects={"damage": {"loss": 0.002, "x": 0.22}})
    best = screening.candidates()[0]
    assert best.effects == ("damage",)
    assert screening.columns[best.columns[0]].shapes["x"] == pytest.approx(0.22)


def test_a_pair_brings_what_neither_brings_alone(toy, pool):
    effects = {"feedthrough": {"gain": 1e-5}, "delay": {"seconds": 3e-8}}
    *_, screening = screened(toy, pool, effects=effects)
    singles = screening.candidates()
    best = screening.pairs(singles)[0]
    assert set(best.effects) == set(effects)
    assert best.gain > singles[0].gain + 10.0


def test_noise_makes_no_candidate(toy, pool):
    *_, screening = screened(toy, pool)
    assert max(c.gain for c in screening.candidates()) < 10.0


def test_an_active_effect_put_back_shows_with_its_evidence(toy, pool):
    plate, sweeps, base, _ = screened(toy, pool, effects={"mass": {"grams": 0.05}})
    fit = fit_gap(plate, sweeps, base.state.with_effects({"mass": {"grams": 0.0}}), ("mass",), pool)
    screening = score_test(plate, sweeps, fit, pool)
    assert screening.active == ("mass",)
    back = {c.effects[0]: c for c in screening.without("mass").candidates()}["mass"]
    assert back.gain == pytest.approx(fit.log_evidence - base.log_evidence, rel=0.02)
    assert back.step[0] == pytest.approx(fit.state.effects["mass"]["grams"], rel=1e-3)


def test_steps_inside_a_box_are_the_best_ones():
    rng = np.random.default_rng(8)
    for _ in range(30):
        root = rng.standard_normal((2, 2))
        matrix, pull = root @ root.T + 0.3 * np.eye(2), 3.0 * rng.standard_normal(2)
        x = solve_inside(matrix, pull, np.array([0.0, -1.0]), np.array([2.0, 1.0]))
        grid = np.array(list(product(np.linspace(0, 2, 41), np.linspace(-1, 1, 41))))
        best = (grid @ pull - 0.5 * np.einsum("ij,jk,ik->i", grid, matrix, grid)).max()
        if np.abs(np.linalg.solve(matrix, pull) - x).max() < 1e-12:  # inside: exact
            assert pull @ x - 0.5 * x @ matrix @ x >= best - 1e-9
        assert (x >= [0.0, -1.0]).all()
        assert (x <= [2.0, 1.0]).all()
    one = solve_inside(np.eye(1), np.array([-2.0]), np.array([0.0]), np.array([1.0]))
    assert one.tolist() == [0.0]


@pytest.mark.parametrize("directions", [("up",), ("up", "down")])
def test_a_lag_is_seen_by_two_ramps_only(toy, pool, directions):
    *_, screening = screened(toy, pool, directions=directions)
    lag = {o.effect: o for o in observability(screening, toy.cards)}["lag"]
    assert lag.observable is (len(directions) == 2)
    assert lag.kept == pytest.approx(float(len(directions) == 2), abs=0.05)
    assert lag.needs == "what lag needs"


def test_a_drift_of_the_gain_is_not_seen_at_one_temperature(toy, pool):
    *_, screening = screened(toy, pool, temperatures=(40.0,))
    seen = {o.effect: o for o in observability(screening, toy.cards)}
    assert not seen["drift"].observable
    assert seen["feedthrough"].observable


def test_look_alikes_are_told_from_strangers(toy, pool):
    plate, sweeps, base, screening = screened(toy, pool, effects={"taper": {"tx": 0.001}})
    table = tangent_cosines(screening, [("taper", 0), ("draught", 0), ("feedthrough", 0)])
    assert table[0, 1] > 0.95
    assert table[0, 2] < 0.3
    fit = fit_gap(plate, sweeps, base.state.with_effects({"taper": {"tx": 0.0}}), ("taper",), pool)
    at = score_test(plate, sweeps, fit, pool)
    assert signal_cosine(at, "taper", "draught") == pytest.approx(table[0, 1], abs=0.02)
    assert signal_cosine(at, "taper", "feedthrough") < 0.3
