"""One pass predicts what a full fit of each candidate would bring."""

from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import pytest

from analysis.effect_card import Parameter
from analysis.gap.fitting.fit import fit_gap
from analysis.gap.search.context import SearchContext
from analysis.gap.search.drop_and_swap import relative_evidence
from analysis.gap.search.observability import observability, signal_cosine, tangent_cosines
from analysis.gap.search.score_test import Column, ScoreTest, score_test, solve_inside

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


@pytest.mark.parametrize("sigma", [0.1, 0.3])
@pytest.mark.parametrize("true", [0.5, 1.9, 4.0, 14.0])
def test_evidence_is_the_integral_over_the_prior(true, sigma):
    """Of one parameter measured with `sigma`, in standard deviations of its prior, from 0 to 14 of them."""
    card = Parameter("a", "1", -100.0, 100.0, 1.0)
    column = Column("effect", 0, card, 0.0, {})
    matrix, gradient = np.array([[sigma**-2.0]]), np.array([true * sigma**-2.0])
    found = ScoreTest((column,), (), matrix, matrix, matrix, gradient).candidates()[0]
    x = np.linspace(-60.0, 60.0, 240_001)
    prior = np.exp([-0.5 * card.penalty(one) for one in x.tolist()])
    likelihood = gradient[0] * x - 0.5 * matrix[0, 0] * x**2
    expected = np.log(np.sum(prior / prior.sum() * np.exp(likelihood - likelihood.max()))) + likelihood.max()
    assert found.gain == pytest.approx(expected, abs=0.1)


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
    lag = {o.effect: o for o in observability(screening, toy.cards, 1)}["lag"]
    assert lag.observable is (len(directions) == 2)
    assert lag.kept == pytest.approx(float(len(directions) == 2), abs=0.05)
    assert lag.needs == "what lag needs"


def test_a_drift_of_the_gain_is_not_seen_at_one_temperature(toy, pool):
    *_, screening = screened(toy, pool, temperatures=(40.0,))
    seen = {o.effect: o for o in observability(screening, toy.cards, 1)}
    assert not seen["drift"].observable
    assert seen["feedthrough"].observable


def test_what_follows_the_amplitude_is_not_seen_at_one_level(toy, pool):
    *_, screening = screened(toy, pool, temperatures=(40.0,))
    cards = {**toy.cards, "feedthrough": replace(toy.cards["feedthrough"], levels=2)}
    alone, both = ({o.effect: o for o in observability(screening, cards, levels)} for levels in (1, 2))
    assert alone["feedthrough"].kept == both["feedthrough"].kept
    assert not alone["feedthrough"].observable
    assert both["feedthrough"].observable


def test_look_alikes_are_told_from_strangers(toy, pool):
    plate, sweeps, base, screening = screened(toy, pool, effects={"taper": {"tx": 0.001}})
    table = tangent_cosines(screening, [("taper", 0), ("draught", 0), ("feedthrough", 0)])
    assert table[0, 1] > 0.95
    assert table[0, 2] < 0.3
    fit = fit_gap(plate, sweeps, base.state.with_effects({"taper": {"tx": 0.0}}), ("taper",), pool)
    at = score_test(plate, sweeps, fit, pool)
    assert signal_cosine(at, "taper", "draught") == pytest.approx(table[0, 1], abs=0.02)
    assert signal_cosine(at, "taper", "feedthrough") < 0.3


COLUMNS = (
    Column("on", 0, Parameter("amount", "1", 0.0, 9.0, 0.5), 0.3, {"place": 0.9}),
    Column("on", 0, Parameter("place", "1", 0.0, 1.0, 0.2, shape=True, typical=0.7), 0.9, {"place": 0.9}),
    Column("also on", 0, Parameter("amount", "1", 0.0, 9.0, 0.1), -0.05, {}),
    Column("off", 0, Parameter("one", "1", -9.0, 9.0, 1.0), 0.0, {}),
    Column("off", 0, Parameter("two", "1", -9.0, 9.0, 1.0), 0.0, {}),
)


@pytest.fixture
def linear(rng):
    """Tangents (40, 5) and residual (40,) of a twin that is linear in its parameters, and their score test."""
    tangents, left = rng.standard_normal((40, 5)), rng.standard_normal(40)
    exact = 3.0 * rng.standard_normal((40, 5))  # with temperatures known exactly
    screening = ScoreTest(
        columns=COLUMNS,
        active=("on", "also on"),
        matrix=tangents.T @ tangents,
        read=exact.T @ exact,
        raw=4.0 * exact.T @ exact,
        gradient=tangents.T @ left,
    )
    return tangents, left, screening


def lowest(tangents, left, effects, steps):
    """Return half the sum of squares and priors at `steps` of the last two columns, at the best of `effects`."""
    known = [i for i, c in enumerate(COLUMNS) if c.effect in effects]
    cards = [COLUMNS[i].card for i in known]
    sigma = np.array([card.sigma for card in cards])
    expected = np.array([card.typical for card in cards]) - [COLUMNS[i].at for i in known]
    rows = np.concatenate([tangents[:, known], np.diag(1.0 / sigma)])
    wanted = np.concatenate([left - tangents[:, 3:] @ steps, expected / sigma])
    return 0.5 * np.linalg.lstsq(rows, wanted, rcond=None)[1][0]


@pytest.mark.parametrize("effects", [("on",), ("on", "also on")])
def test_effects_are_eliminated_at_their_best_under_their_priors(linear, rng, effects):
    """The prior is about zero for an amplitude and about its typical value for a shape."""
    tangents, left, screening = linear
    matrix, gradient = (part[..., 3:] for part in screening.given(effects))
    np.testing.assert_allclose(screening.given(effects)[0], screening.given(effects)[0].T, rtol=1e-12)
    for steps in rng.standard_normal((3, 2)):
        change = lowest(tangents, left, effects, steps) - lowest(tangents, left, effects, np.zeros(2))
        assert 0.5 * steps @ matrix[3:] @ steps - gradient @ steps == pytest.approx(change, rel=1e-9)
    known = replace(screening, matrix=screening.read).given(effects)[0]
    np.testing.assert_allclose(screening.kept(effects), known, rtol=1e-12)


def test_an_effect_put_back_leaves_its_signal_in_the_residual_and_its_shape_out(linear):
    tangents, left, screening = linear
    back = screening.without("on")
    assert [(c.effect, c.card.name, c.at) for c in back.columns] == [
        ("on", "amount", 0.0), ("also on", "amount", -0.05), ("off", "one", 0.0), ("off", "two", 0.0)
    ]  # fmt: skip
    assert back.active == ("also on",)
    assert back.inactive == ("on", "off")
    rest = [0, 2, 3, 4]
    np.testing.assert_allclose(back.gradient, tangents[:, rest].T @ (left + 0.3 * tangents[:, 0]), rtol=1e-12)
    for name in ("matrix", "read", "raw"):
        np.testing.assert_array_equal(getattr(back, name), getattr(screening, name)[np.ix_(rest, rest)])


def test_data_four_times_over_weigh_four_times_as_much(linear):
    tangents, left, screening = linear
    again = screening.scaled(4.0)
    np.testing.assert_allclose(again.matrix, np.tile(tangents, (4, 1)).T @ np.tile(tangents, (4, 1)), rtol=1e-12)
    np.testing.assert_allclose(again.gradient, np.tile(tangents, (4, 1)).T @ np.tile(left, 4), rtol=1e-12)
    for name in ("read", "raw"):
        np.testing.assert_allclose(getattr(again, name), 4.0 * getattr(screening, name), rtol=1e-12)
    assert again.columns is screening.columns


def test_a_prior_that_counts_a_quarter_is_twice_as_wide(toy, pool):
    """As of declared quantities, where lines state more noise than they have; effects keep their priors."""

    @dataclass
    class Tolerant(toy.Plate):
        @property
        def tolerance_cards(self):
            return {"mass": toy.cards["mass"]}

        @property
        def cards(self):
            return {name: toy.cards[name] for name in ("taper", "feedthrough")}

    sweeps, _ = toy.prepared(temperatures=(18.0, 26.0))
    fit = fit_gap(
        Tolerant(), sweeps, toy.start(sweeps.groups).with_effects({"taper": {"tx": 0.0}}), ("taper",), pool
    )
    for trusted in (1.0, 0.25):
        there = replace(fit, free=replace(fit.free, trusted=trusted))
        sigmas = {c.effect: c.card.sigma for c in score_test(Tolerant(), sweeps, there, pool).columns}
        assert sigmas == {"mass": pytest.approx(1.0 / np.sqrt(trusted)), "taper": 0.02, "feedthrough": 0.01}


def test_a_second_is_a_candidate_once_its_first_is_on_and_no_rival_of_it(toy, pool):
    class Twice(toy.Plate):
        @property
        def cards(self):
            return {
                **super().cards,
                "second_damage": replace(toy.cards["damage"], name="second_damage", after="damage"),
            }

    there = {"loss": 0.2, "x": 0.22}
    sweeps, noise = toy.prepared(temperatures=TEMPERATURES, effects={"damage": there})
    plate = Twice()
    base = fit_gap(plate, sweeps, toy.start(sweeps.groups), (), pool)
    assert "second_damage" not in score_test(plate, sweeps, base, pool).inactive
    fit = fit_gap(plate, sweeps, base.state.with_effects({"damage": there}), ("damage",), pool)
    last = score_test(plate, sweeps, fit, pool)
    assert "second_damage" in last.inactive
    context = SearchContext(plate, sweeps, noise, pool)
    rivals = relative_evidence(context, fit, last, "damage", ())
    assert "mass" in rivals
    assert "second_damage" not in rivals
