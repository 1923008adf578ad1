"""Panels with one side warmer than the other, on a plate whose local stiffness is known."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from analysis.compensation.tilted import TILTS, tilted_contrast
from analysis.focusing.over_temperature import focus
from analysis.focusing.performance import contrast


@dataclass(frozen=True)
class AsWarmAsItsTarget:
    """A panel that answers, whatever the rest of it, as if all of it were as warm as its target."""

    plate: Any
    laws: Any

    @property
    def space(self):
        return self.plate.space

    def amplitudes(self, temperature, across, frequency):
        xi, zeta = self.plate.panel.plate.normalised(np.array([self.plate.panel.target_center]))
        here = temperature + 0.5 * (across[0] * xi[0] + across[1] * zeta[0])
        material = self.laws.at(here)
        constants = (material.youngs_modulus, material.poisson_ratio, material.loss_factor)
        return self.plate.amplitudes(*(float(x[0]) for x in constants), frequency)


@pytest.fixture(scope="module")
def plain(make_plate, make_panel, six):
    settings = {"taps": 128, "sample_rate": 11_025.0, "delay": 64, "transform_length": 1_024}
    return make_plate(make_panel(six, band=(100.0, 500.0), edges=(60.0, 560.0), **settings))


@pytest.fixture(scope="module")
def found(plain, softening):
    def taps(temperature):
        return focus(plain, plain.panel, softening, temperature).bank.taps

    like = focus(plain, plain.panel, softening, np.array([20.0])).bank
    model = AsWarmAsItsTarget(plain, softening)
    return tilted_contrast(model, plain.panel, like, taps, (10.0, 20.0), (0.0, 60.0))


def test_every_side_is_the_warmer_one_and_all_of_the_panel_stays_within_the_laws(plain, found):
    np.testing.assert_array_equal(found.difference, [10.0, 20.0])
    np.testing.assert_allclose(found.temperature, [[5.0, 30.0, 55.0], [10.0, 30.0, 50.0]])
    xi, zeta = 2.0 * np.array(plain.panel.target.center) - 1.0
    shares = np.array([xi, -xi, zeta, -zeta])
    np.testing.assert_allclose(found.at_target[1, 0], 10.0 + 10.0 * shares)
    assert len(TILTS) == 4


def test_filters_of_the_target_s_temperature_are_right_where_only_the_target_counts(plain, softening, found):
    """A panel as warm as its target is focused by the filters of the target's temperature as a uniform one is."""
    at = found.at_target[1, 1]
    focused = focus(plain, plain.panel, softening, np.sort(at)).direct.contrast
    order = np.argsort(np.argsort(at))
    np.testing.assert_allclose(found.fed_target[1, 1, :, 0], focused.mean(axis=1)[order])
    np.testing.assert_allclose(found.fed_target[1, 1, :, 1], focused.min(axis=1)[order])
    np.testing.assert_allclose(found.uniform[:, 1], found.uniform[0, 1][None].repeat(2, axis=0))
    middle = found.loss(found.fed_mean)
    assert (found.loss(found.fed_target) < middle).all()
    assert (middle[1] > middle[0]).all()


def test_filters_of_the_middle_are_judged_on_the_warmer_panel(plain, softening, found):
    lines = plain.panel.filters.frequency
    lines = lines[plain.panel.filters.in_band(lines)]
    bank = focus(plain, plain.panel, softening, np.array([30.0])).bank
    amplitude = AsWarmAsItsTarget(plain, softening).amplitudes(30.0, (20.0, 0.0), lines)
    exact = contrast(plain.space.forms([amplitude]), bank.response(lines))[0]
    np.testing.assert_allclose(found.fed_mean[1, 1, 0], [exact.mean(), exact.min()])


def test_a_difference_wider_than_the_laws_is_refused(plain, softening):
    model = AsWarmAsItsTarget(plain, softening)
    like = focus(plain, plain.panel, softening, np.array([20.0])).bank
    with pytest.raises(ValueError, match="70 K across the panel: the laws hold for 0 to 60 °C"):
        tilted_contrast(model, plain.panel, like, lambda t: like.taps, (10.0, 70.0), (0.0, 60.0))
