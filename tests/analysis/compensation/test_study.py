from itertools import count

import numpy as np
import pytest

from analysis.compensation.network import relative_error
from analysis.compensation.outcome import METHODS
from analysis.compensation.rivals import log_root_rigidity
from analysis.compensation.settings import Training
from analysis.compensation.study import compensate
from analysis.focusing.over_temperature import focus


@pytest.fixture(scope="module")
def plain(make_plate, make_panel, six):
    settings = {"taps": 128, "sample_rate": 11_025.0, "delay": 64, "transform_length": 1_024}
    return make_plate(make_panel(six, band=(100.0, 500.0), edges=(60.0, 560.0), **settings))


@pytest.fixture(scope="module")
def studied(plain, softening):
    ticks = count()
    return compensate(plain, plain.panel, softening, 5.0, Training(), lambda: float(next(ticks)), step=1.0)


def test_every_method_is_judged_at_every_temperature(studied):
    assert studied.methods == METHODS
    np.testing.assert_allclose(studied.temperature, np.arange(0.0, 60.5, 1.0))
    np.testing.assert_allclose(studied.training_temperature, np.arange(0.0, 60.5, 5.0))
    assert studied.relative_error.shape == (6, 61, 6)
    assert studied.left_out.shape == (6, 11, 6)
    assert studied.contrast.shape == (6, 61, len(studied.frequency))
    np.testing.assert_array_equal(studied.seconds, 1.0)  # two readings of the clock handed in


def test_the_networks_lose_next_to_no_contrast_at_any_line_of_any_temperature(studied):
    assert studied.contrast_loss[0].max() < 0.005
    assert studied.largest_loss[0] == studied.contrast_loss[0].max()


def test_interpolations_are_exact_where_they_were_fitted(studied):
    knots = np.isin(studied.temperature, studied.training_temperature)
    assert studied.relative_error[1:4][:, knots].max() < 1e-20
    assert studied.relative_error[4, knots].max() > studied.relative_error[1:4, knots].max()  # refitted
    assert studied.relative_error[1, ~knots].min() > 1e-9


def test_the_best_method_is_the_one_that_loses_least_contrast_on_the_worst_line(studied):
    largest = (studied.contrast_direct - studied.contrast).max(axis=(1, 2))
    assert studied.best == studied.methods[int(largest.argmin())]


def test_errors_and_contrasts_are_those_of_filters_designed_on_the_spot(plain, softening, studied):
    """Paper eq. (13) of the networks against `focus`, which shares no array with the study."""
    at = np.array([0.0, 17.0, 43.0])
    focused = focus(plain, plain.panel, softening, at)
    taps = studied.trained.networks.taps(at)
    exact = relative_error(taps, focused.bank.taps)
    np.testing.assert_allclose(studied.relative_error[0, [0, 17, 43]], exact, rtol=1e-6)
    np.testing.assert_allclose(studied.contrast_direct[[0, 17, 43]], focused.direct.contrast, atol=1e-12)


def test_spot_errors_belong_to_their_temperatures(plain, softening, studied):
    assert studied.aim_temperature.tolist() == list(np.arange(0.0, 61.0, 5.0))
    focused = focus(plain, plain.panel, softening, studied.aim_temperature[[2, 9]])
    np.testing.assert_allclose(studied.direct_aim.spot_error[[2, 9]], focused.direct.spot_error)
    np.testing.assert_allclose(studied.network_aim.contrast, studied.contrast[0, ::5], atol=1e-12)


def test_what_is_left_out_is_missed_by_more_than_what_is_trained_on(studied):
    trained_on = studied.relative_error[:, 5:-5:5]
    assert trained_on.shape == studied.left_out.shape
    fitted = slice(0, 4)  # the last, refitted to the taps, is not exact where it was fitted
    assert np.all(studied.left_out[fitted].max(axis=2) > 10.0 * trained_on[fitted].max(axis=2))


def test_the_recommended_method_is_the_smallest_that_loses_nothing_worth_mentioning(studied):
    fair = studied.largest_loss <= 0.005
    assert studied.recommended in np.array(studied.methods)[fair]
    assert studied.size[studied.methods.index(studied.recommended)] == studied.size[fair].min()
    memory = f"of least memory ({studied.size[fair].min() / 1e3:.0f} kB)"
    reason = f"{memory} among those that nowhere lose more than 0.005"
    assert studied.recommendation == f"{studied.recommended}, {reason}"
    count, actuators, taps = studied.filters.taps.shape
    assert studied.size[studied.methods.index("linear")] == 4 * count * actuators * taps
    network = studied.trained.networks
    parts = (network.slope, network.bias, network.output)
    assert studied.size[0] == 4 * sum(part.size for part in parts)
    kept = studied.low_rank
    assert studied.size[-1] == 4 * (kept.coefficient.size + kept.filters.size + kept.mean.size)


def test_stiffness_alone_orders_the_temperatures(softening):
    material = softening.at(np.arange(0.0, 61.0))
    u = log_root_rigidity(material.youngs_modulus, material.poisson_ratio)
    assert np.all(np.diff(u) < 0.0)


def test_too_few_training_temperatures_are_refused_before_any_work(plain, softening):
    def clock():
        raise AssertionError("nothing should have been timed")

    with pytest.raises(ValueError, match="3 training temperatures; at least 4 are needed"):
        compensate(plain, plain.panel, softening, 30.0, Training(), clock)
