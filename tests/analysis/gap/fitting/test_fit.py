"""The joint fit finds what was put in, and errs by what it says."""

from dataclasses import replace

import numpy as np
import pytest

from analysis.gap.fitting.fit import fit_gap
from analysis.gap.fitting.normal_equations import GLOBAL, linearise_all

TEMPERATURES = tuple(np.arange(2.0, 39.0, 4.0))


def test_laws_come_out_within_their_errors(toy, pool):
    sweeps, noise = toy.prepared(temperatures=TEMPERATURES, reading_sigma=0.0)
    fit = fit_gap(toy.Plate(), sweeps, toy.start(sweeps.groups), (), pool)
    pull = (fit.state.laws - toy.laws(sweeps.groups.reference)) / fit.noise.laws
    assert fit.settled
    assert np.sqrt(np.mean(pull**2)) < 1.6
    assert abs(noise.z(fit.total, fit.dof)) < 4.0
    assert fit.state.log_gain == pytest.approx(np.log(toy.gain), abs=5.0 * float(fit.noise.log_gain[0]))


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("mass", {"grams": 1.5}),
        ("lag", {"tau": 240.0}),
        ("stretch", {"delta_e": 0.02, "delta_g": -0.01}),
        ("bond", {"gamma": 0.08, "softening": 0.04}),
        ("damage", {"loss": 0.04, "x": 0.29}),
    ],
)
def test_an_effect_comes_out_within_its_errors(toy, pool, name, values):
    sweeps, noise = toy.prepared(temperatures=TEMPERATURES, effects={name: values})
    card = toy.cards[name]
    site = {"x": 0.3} if name == "damage" else card.sites[0]
    plain = fit_gap(toy.Plate(), sweeps, toy.start(sweeps.groups), (), pool)
    start = plain.state.with_effects({name: card.zero(site)})
    fit = fit_gap(toy.Plate(), sweeps, start, (name,), pool)
    found = fit.state.effects[name]
    for (_, parameter), sigma in zip(fit.free.names, fit.noise.parameters, strict=True):
        assert found[parameter] == pytest.approx(values[parameter], abs=4.0 * sigma)
    assert noise.z(fit.total, fit.dof) < 3.0
    assert fit.on_wall == ()


@pytest.mark.parametrize("step", [5.0, 10.0, 15.0])
def test_a_lag_of_several_kelvins_on_laws_that_bend(toy, pool, step):
    """The plate is asked 5 K from the readings: slopes and curvatures of the laws count, and their errors."""
    sweeps, noise = toy.prepared(
        temperatures=tuple(np.arange(2.0, 63.0, step)), effects={"lag": {"tau": 750.0}}, reading_sigma=0.0
    )
    plain = fit_gap(toy.Plate(), sweeps, toy.start(sweeps.groups), (), pool)
    fit = fit_gap(toy.Plate(), sweeps, plain.state.with_effects({"lag": {"tau": 0.0}}), ("lag",), pool)
    assert fit.settled
    assert noise.z(fit.total, fit.dof) < 3.0
    assert fit.state.effects["lag"]["tau"] == pytest.approx(750.0, abs=4.0 * float(fit.noise.parameters[0]))
    pull = (fit.state.laws - toy.laws(sweeps.groups.reference)) / fit.noise.laws
    assert np.sqrt(np.mean(pull**2)) < 1.5


def test_the_gradient_is_that_of_chi2(toy, pool):
    sweeps, _ = toy.prepared(temperatures=(10.0, 12.0))
    state = toy.start(sweeps.groups).with_effects({"mass": {"grams": 0.3}})
    plate = toy.Plate()

    def chi2(at):
        return sum(e.chi2 for e in linearise_all(plate, sweeps, at, (), pool))

    equations = linearise_all(plate, sweeps, state, [("mass", "grams", {"grams": 0.3})], pool)
    h = 1e-5
    up = chi2(state.with_effects({"mass": {"grams": 0.3 + h}}))
    down = chi2(state.with_effects({"mass": {"grams": 0.3 - h}}))
    assert (up - down) / (2 * h) == pytest.approx(-2.0 * sum(e.gradient[-1] for e in equations), rel=1e-4)
    up, down = (chi2(replace(state, log_gain=state.log_gain + s * h)) for s in (1, -1))
    assert (up - down) / (2 * h) == pytest.approx(-2.0 * sum(e.gradient[GLOBAL] for e in equations), rel=1e-4)


def test_a_parameter_stays_at_the_wall_that_it_is_pushed_against(toy, pool):
    # what looks like a negative mass: stiffer modes where the cable sits
    sweeps, _ = toy.prepared(temperatures=TEMPERATURES, effects={"softening": {"a": -0.01, "b": 0.0}})
    start = toy.start(sweeps.groups).with_effects({"mass": {"grams": 0.0}})
    fit = fit_gap(toy.Plate(), sweeps, start, ("mass",), pool)
    assert fit.state.effects["mass"]["grams"] == 0.0
    assert fit.on_wall == (("mass", "grams"),)


def test_a_shape_that_is_not_told_from_its_bound_makes_another_effect(toy, pool):
    """A relaxation far below the band is a loss that falls with frequency, and was named with 0.95."""
    sweeps, _ = toy.prepared(temperatures=TEMPERATURES, effects={"damage": {"loss": 0.3, "x": 0.33}})
    start = toy.start(sweeps.groups).with_effects({"damage": {"loss": 0.2, "x": 0.4}})
    for low, another in ((0.05, ()), (0.33, ("damage",)), (0.36, ("damage",))):
        fit = fit_gap(toy.bounded(toy.Plate(), "damage", "x", low), sweeps, start, ("damage",), pool)
        assert fit.become_another == another
        assert fit.plausible == (not another)
    assert fit_gap(toy.Plate(), sweeps, start, ("damage",), pool).plausible  # a place may be at the plate's edge


def test_held_effects_and_gain_do_not_move(toy, pool):
    sweeps, _ = toy.prepared(temperatures=TEMPERATURES, effects={"mass": {"grams": 1.0}})
    start = toy.start(sweeps.groups).with_effects({"mass": {"grams": 0.9}})
    fit = fit_gap(toy.Plate(), sweeps, start, (), pool, gain_free=False)
    assert fit.state.effects == {"mass": {"grams": 0.9}}
    assert fit.state.log_gain == start.log_gain
    assert fit.noise.log_gain == 0.0


def test_a_model_that_refuses_a_step_is_asked_for_a_smaller_one(toy, pool):
    class Narrow(toy.Plate):
        def linearise(self, laws, frequency, effects, point, tangents=()):
            if effects["mass"]["grams"] > 1.55:
                raise ValueError("out of the certified range")
            return super().linearise(laws, frequency, effects, point, tangents)

    sweeps, _ = toy.prepared(temperatures=(10.0, 26.0), effects={"mass": {"grams": 1.5}})
    start = toy.start(sweeps.groups).with_effects({"mass": {"grams": 0.0}})
    fit = fit_gap(Narrow(), sweeps, start, ("mass",), pool, most_steps=30)
    assert fit.state.effects["mass"]["grams"] == pytest.approx(1.5, abs=0.02)


def test_an_effect_counted_in_units_of_the_plain_plate_follows_its_laws(toy, pool):
    """A model whose parameters are in a unit that the loss at 26 degrees makes: laws that move take it along."""
    truth = toy.start(toy.prepared(temperatures=(10.0, 26.0))[0].groups, off=0.0)

    class Counted(toy.Plate):
        unit = 1.3

        def counted(self, laws, effects):
            assert list(effects) == ["softening"]
            found = Counted()
            found.unit = np.exp(2.0 * (laws[1].value[2] - truth.laws[1, 2]))
            return found

        def linearise(self, laws, frequency, effects, point, tangents=()):
            def scaled(values):
                return {name: {p: v * self.unit for p, v in entries.items()} for name, entries in values.items()}

            inside = [(name, p, scaled({name: at})[name]) for name, p, at in tangents]
            line = super().linearise(laws, frequency, scaled(effects), point, inside)
            return replace(line, by_parameter=self.unit * line.by_parameter)

    values = {"softening": {"a": -0.01, "b": 0.02}}
    sweeps, _ = toy.prepared(temperatures=(10.0, 26.0), levels=(1.0, 2.0), effects=values)
    start = toy.start(sweeps.groups).with_effects({"softening": {"a": 0.0, "b": 0.0}})
    fit = fit_gap(Counted(), sweeps, start, ("softening",), pool, most_steps=30)
    sigma = fit.noise.parameters
    off = np.array([fit.state.effects["softening"][p] - values["softening"][p] for p in ("a", "b")])
    assert (np.abs(off) < 4.0 * sigma).all()
    assert (0.3 * np.array([0.01, 0.02]) > 8.0 * sigma).all()  # the unit it began with would be far outside


def test_evidence_charges_for_a_parameter_that_explains_nothing(toy, pool):
    sweeps, _ = toy.prepared(temperatures=TEMPERATURES)
    plate = toy.Plate()
    bare = fit_gap(plate, sweeps, toy.start(sweeps.groups), (), pool)
    more = fit_gap(plate, sweeps, bare.state.with_effects({"drift": {"alpha": 0.0}}), ("drift",), pool)
    assert more.total <= bare.total + 0.1
    assert more.log_evidence < bare.log_evidence - 3.0


def test_a_fit_that_cannot_reach_what_it_must_is_given_up(toy, pool):
    sweeps, _ = toy.prepared(temperatures=(10.0, 26.0), effects={"mass": {"grams": 1.5}})
    start = toy.start(sweeps.groups).with_effects({"mass": {"grams": 0.0}})
    whole = fit_gap(toy.Plate(), sweeps, start, ("mass",), pool)
    reached = -2.0 * whole.log_evidence
    kept = fit_gap(toy.Plate(), sweeps, start, ("mass",), pool, enough=reached)
    assert kept.settled
    assert kept.log_evidence == whole.log_evidence
    gained = fit_gap(toy.Plate(), sweeps, start, (), pool).total - whole.total
    left = fit_gap(toy.Plate(), sweeps, start, ("mass",), pool, enough=reached - 10.0 * gained)
    assert not left.settled
    assert left.passes < whole.passes


def test_readings_of_a_plate_that_lags_behind_are_found_between_the_temperatures_of_a_fit(toy, pool):
    """What a fit to a few temperatures finds of the readings is the start for all of them."""
    sweeps, _ = toy.prepared(temperatures=tuple(range(2, 59, 4)), directions=("up", "down"))
    few = sweeps.only_groups(range(0, 15, 2))
    start = toy.start(sweeps.groups)
    part = start.restricted(sweeps, few)
    ramp = np.repeat([-1.0, 1.0], 15)  # colder than the oven on the way up, warmer on the way down

    def behind(temperature):
        return 1.0 + 0.01 * temperature

    temperature = np.concatenate([np.arange(2.0, 59.0, 4.0), np.arange(58.0, 1.0, -4.0)])
    true = ramp * behind(temperature)
    found = replace(part, away=true[few.original_places(sweeps)])
    spread = start.corrected(sweeps, part, found, few)
    inner = np.abs(temperature - 58.0) > 4.0  # between the ramps it turns round
    np.testing.assert_allclose(spread.away[inner], true[inner], atol=1e-9)
    means = [spread.away[sweeps.groups.of_sweep == group].mean() for group in range(15)]
    np.testing.assert_allclose(means, 0.0, atol=1e-12)
    np.testing.assert_allclose(spread.laws, start.laws)


def test_a_part_of_a_campaign_keeps_the_slopes_of_the_laws(toy):
    """In a part, other temperatures are neighbours; the laws are what they were."""
    sweeps, _ = toy.prepared(temperatures=tuple(range(2, 59, 4)), directions=("up", "down"))
    rng = np.random.default_rng(5)
    state = toy.start(sweeps.groups)
    state = replace(state, tilt=1e-4 * rng.standard_normal((15, 3)), bend=1e-6 * rng.standard_normal((15, 3)))
    slope, curvature = sweeps.smoothness.derivatives(state.laws)
    few = sweeps.only_groups(range(0, 15, 2))
    part = state.restricted(sweeps, few)
    there = few.smoothness.derivatives(part.laws)
    np.testing.assert_allclose(there[0] + part.tilt, (slope + state.tilt)[::2], rtol=1e-12)
    np.testing.assert_allclose(there[1] + part.bend, (curvature + state.bend)[::2], rtol=1e-12)
    up = sweeps.only([s for s, way in enumerate(sweeps.direction) if way == "up"])
    moved = up.groups.reference - sweeps.groups.reference
    one = state.restricted(sweeps, up)
    expected = (
        state.laws + moved[:, None] * (slope + state.tilt) + 0.5 * moved[:, None] ** 2 * (curvature + state.bend)
    )
    np.testing.assert_allclose(one.laws, expected, rtol=1e-12)
