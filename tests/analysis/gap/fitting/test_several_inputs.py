"""Sweeps of several inputs fitted jointly: one set of laws and effects, a gain for each input."""

from dataclasses import replace

import numpy as np
import pytest

from analysis.gap.fitting.fit import fit_gap
from analysis.gap.fitting.residual_map import neighbours
from analysis.gap.gap import find_gap
from analysis.gap.search.held_out import splits

TEMPERATURES = tuple(np.arange(2.0, 39.0, 4.0))
MASS = {"mass": {"grams": 1.5}}


@pytest.fixture(scope="module")
def fits(toy, pool):
    """Fits of two inputs together, and of each alone."""
    sweeps, noise = toy.prepared(temperatures=TEMPERATURES, sources=(0, 1), effects=MASS, reading_sigma=0.0)
    driven = np.array([point.source for point in sweeps.points])
    parts = [sweeps, *(sweeps.only(np.flatnonzero(driven == source)) for source in (0, 1))]
    starts = [toy.start(part.groups, inputs=2).with_effects({"mass": {"grams": 0.0}}) for part in parts]
    fitted = [
        fit_gap(toy.Plate(), part, start, ("mass",), pool) for part, start in zip(parts, starts, strict=True)
    ]
    assert abs(noise.z(fitted[0].total, fitted[0].dof)) < 4.0
    return sweeps, fitted, starts


def test_laws_gains_and_the_effect_come_out_within_their_errors(toy, fits):
    sweeps, (joint, *_), _ = fits
    pull = (joint.state.laws - toy.laws(sweeps.groups.reference)) / joint.noise.laws
    assert joint.settled
    assert np.sqrt(np.mean(pull**2)) < 1.6
    off = joint.state.log_gain - np.log(toy.gains)
    assert (np.abs(off) < 5.0 * joint.noise.log_gain).all()
    assert joint.state.effects["mass"]["grams"] == pytest.approx(1.5, abs=4.0 * joint.noise.parameters[0])


def test_two_inputs_tell_more_than_either(fits):
    _, (joint, *alone), _ = fits
    for one in alone:
        assert joint.noise.parameters[0] < 0.95 * one.noise.parameters[0]
        assert (joint.noise.laws < one.noise.laws).all()


def test_the_gain_of_an_input_that_drove_no_sweep_stays(toy, fits):
    _, (_, first, second), (_, start, _) = fits
    assert first.state.log_gain[1] == start.log_gain[1]
    assert first.noise.log_gain[1] == second.noise.log_gain[0] == 0.0
    assert first.dof == pytest.approx(second.dof)
    assert first.state.log_gain[0] == pytest.approx(np.log(toy.gains[0]), abs=5.0 * float(first.noise.log_gain[0]))


def test_the_effect_is_named_from_both_inputs(toy, pool):
    frf, rig = toy.record(temperatures=TEMPERATURES, directions=("up",), sources=(0, 1), effects=MASS, spacing=2.0)
    plate = toy.Plate(left_out=tuple(name for name in toy.cards if name not in ("mass", "stretch", "feedthrough")))
    found = find_gap(frf, toy.updated(frf), plate, rig, pool)
    assert found.verdict == "explained"
    (effect,) = found.effects
    assert effect.name == "mass"
    assert effect.parameters[0].value == pytest.approx(1.5, abs=4.0 * effect.parameters[0].sigma)
    assert np.abs(np.exp(found.state.log_gain) - toy.gains) == pytest.approx(0.0, abs=5.0 * found.sigma_gain.max())


def test_neighbours_in_temperature_have_one_input(fits):
    sweeps, *_ = fits
    pairs = neighbours(sweeps)
    assert len(pairs) == sweeps.count - len(sweeps.legs) > 0
    assert len(sweeps.legs) == 4  # two ways, two inputs
    for left, right in pairs:
        assert sweeps.points[left].source == sweeps.points[right].source
        assert sweeps.points[left].temperature < sweeps.points[right].temperature


def test_the_highest_level_of_each_input_is_held_out_and_no_input_as_a_whole(toy):
    sweeps, _ = toy.prepared(temperatures=TEMPERATURES[:2], directions=("up",), levels=(1.0, 2.0), sources=(0, 1))
    volts_and_newtons = tuple(
        replace(p, level=10.0 * p.level if p.source == 0 else p.level) for p in sweeps.points
    )
    *_, split = splits(replace(sweeps, points=volts_and_newtons, channels=("S1",)))
    assert split.what == "highest level of each actuator"
    assert {(p.source, p.level) for p in split.test.points} == {(0, 20.0), (1, 2.0)}
    assert {(p.source, p.level) for p in split.learn.points} == {(0, 10.0), (1, 1.0)}
    one_each = tuple(replace(p, level=10.0 if p.source == 0 else 1.0) for p in sweeps.points)
    assert all("level" not in split.what for split in splits(replace(sweeps, points=one_each, channels=("S1",))))
