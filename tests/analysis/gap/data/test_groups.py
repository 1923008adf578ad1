"""Groups of temperature, and how the laws run on from them."""

import numpy as np
import pytest

from analysis.gap.data.groups import TemperatureGroups, law_derivatives, mean_laws
from analysis.material import Material


def test_up_and_down_ramps_meet_at_each_temperature():
    readings = np.array([10.02, 20.03, 30.0, 29.95, 20.01, 9.97])
    groups = TemperatureGroups.of(readings)
    assert groups.of_sweep.tolist() == [0, 1, 2, 2, 1, 0]
    assert groups.reference == pytest.approx([9.995, 20.02, 29.975])


def test_a_slow_drift_does_not_chain_into_one_group():
    groups = TemperatureGroups.of(np.arange(0.0, 5.0, 0.3), tolerance=0.5)
    assert groups.size.max() == 2


@pytest.mark.parametrize(("step", "within"), [(2.0, 0.02), (4.0, 0.02)])
def test_slopes_and_curvatures_of_a_transition(step, within):
    t = np.arange(0.0, 61.0, step)
    value = -0.008 * t - 0.15 * np.tanh((t - 8.0) / 10.0)
    slope = -0.008 - 0.015 / np.cosh((t - 8.0) / 10.0) ** 2
    curvature = 0.003 * np.tanh((t - 8.0) / 10.0) / np.cosh((t - 8.0) / 10.0) ** 2
    found, bent, _ = law_derivatives(t, np.stack([value] * 3, axis=1))
    assert np.sqrt(np.mean((found[:, 0] / slope - 1.0) ** 2)) < within
    assert np.sqrt(np.mean((bent[:, 0] - curvature) ** 2)) < 0.15 * np.abs(curvature).max()


def test_straight_laws_have_their_slope_from_two_temperatures_on():
    for t in (np.array([10.0, 40.0]), np.array([10.0, 20.0, 50.0])):
        values = np.outer(t, [-0.01, 0.001, 0.02])
        slope, curvature, _ = law_derivatives(t, values)
        assert slope == pytest.approx(np.tile([-0.01, 0.001, 0.02], (len(t), 1)), abs=1e-9)
        assert curvature == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("sweeps", [1, 3])
def test_one_temperature_says_nothing_of_a_slope(sweeps):
    slope, curvature, sigma = law_derivatives(np.full(sweeps, 20.0), np.arange(3.0 * sweeps).reshape(sweeps, 3))
    assert not slope.any()
    assert not curvature.any()
    assert not sigma.any()


def test_slopes_between_distant_temperatures_are_as_uncertain_as_they_are_wrong():
    t = np.array([5.0, 25.0, 45.0])
    pulls = []
    for centre in np.arange(-10.0, 61.0, 5.0):
        value = -0.008 * t - 0.1 * np.tanh((t - centre) / 15.0)
        slope = -0.008 - 0.1 / 15.0 / np.cosh((t - centre) / 15.0) ** 2
        found, _, sigma = law_derivatives(t, np.stack([value] * 3, axis=1))
        pulls.append((found[:, 0] - slope) / sigma[:, 0])
    assert 0.2 < np.sqrt(np.mean(np.square(pulls))) < 3.0


def test_slopes_are_the_less_known_the_further_apart_the_temperatures(toy):
    spread = []
    for step in (2.0, 4.0, 20.0):
        t = np.arange(0.0, 61.0, step)
        spread.append(np.median(TemperatureGroups.of(t).slope_sigma(toy.laws(t))[:, 0]))
    assert 0.0 < spread[0] < spread[1] < spread[2]


def test_groups_start_from_the_mean_of_their_sweeps():
    groups = TemperatureGroups.of(np.array([10.0, 20.0, 10.1]))
    material = Material(np.exp([1.0, 5.0, 3.0]), np.array([0.3, 0.4, 0.32]), np.exp([-3.0, -2.0, -3.2]))
    assert mean_laws(material, groups)[0] == pytest.approx([2.0, 0.31, -3.1])
