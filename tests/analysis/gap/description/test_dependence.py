"""Strength of a cause by circumstance, on a toy whose cause changes as we say."""

import numpy as np
import pytest

from analysis.gap.data.preparation import prepare
from analysis.gap.description.describing import dependences
from analysis.gap.fitting.fit import fit_gap

TEMPERATURES = (2.0, 14.0, 26.0, 38.0)
GAIN = 2e-3


@pytest.fixture(scope="module")
def depends(toy, pool):
    def run(extra=None, **kwargs):
        frf, rig = toy.record(temperatures=TEMPERATURES, extra=extra, **kwargs)
        plate = toy.Plate(2, ())
        sweeps, _ = prepare(frf, rig, toy.updated(frf))
        start = toy.start(sweeps.groups).with_effects({"feedthrough": {"gain": 0.0}})
        fit = fit_gap(plate, sweeps, start, ("feedthrough",), pool)
        return {one.on: one for one in dependences(plate, sweeps, fit, "feedthrough", pool, sweeps.overstated)}

    return run


def test_what_is_the_same_everywhere_is_constant(depends):
    found = depends(lambda f, t: GAIN * np.ones_like(f) + 0j)
    assert set(found) == {"temperature", "ramp", "time", "channel"}
    assert found["temperature"].label == ("2 °C", "14 °C", "26 °C", "38 °C")
    assert found["channel"].label == ("S1", "S2")
    for one in found.values():
        assert one.constant
        np.testing.assert_allclose(one.factor, 1.0, atol=4.0 * one.sigma.max())


def test_what_grows_with_temperature_is_seen_to(depends):
    """From half to one and a half of its mean: the factors are those of the truth over the fit to all."""
    found = depends(lambda f, t: GAIN * (0.5 + (t - 2.0) / 36.0) * np.ones_like(f) + 0j)
    one = found["temperature"]
    assert not one.constant
    np.testing.assert_allclose(one.factor / one.factor.mean(), [0.5, 5.0 / 6.0, 7.0 / 6.0, 1.5], atol=0.1)
    assert found["channel"].constant


def test_levels_are_told_apart_where_there_are_two(depends):
    found = depends(lambda f, t: GAIN * np.ones_like(f) + 0j, levels=(1.0, 2.0))
    assert found["level"].label == ("1 V", "2 V")
    assert found["level"].constant


def test_a_cause_without_strength_depends_on_nothing(toy, pool):
    frf, rig = toy.record(temperatures=TEMPERATURES)
    plate = toy.Plate(2, ())
    sweeps, _ = prepare(frf, rig, toy.updated(frf))
    start = toy.start(sweeps.groups).with_effects({"mass": {"grams": 0.0}})
    fit = fit_gap(plate, sweeps, start, ("mass",), pool)
    still = type(fit)(**{**vars(fit), "state": fit.state.with_effects({"mass": {"grams": 0.0}})})
    assert dependences(plate, sweeps, still, "mass", pool, 1.0) == ()
