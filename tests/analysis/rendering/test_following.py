"""One form for networks, splines, straight lines and single filters."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from analysis.compensation.network import InputMap, NetworkBank
from analysis.compensation.rivals import cubic_spline, linear
from analysis.focusing.fir import FirBank
from analysis.rendering.following import FixedPoint, FollowingBank

WANTED = np.array([-10.0, 0.0, 3.3, 20.0, 41.7, 60.0, 80.0])


def test_a_spline_is_the_spline_through_every_tap(filters):
    bank = filters(np.arange(0.0, 61.0, 5.0))
    found = FollowingBank.of_filters(bank).taps(WANTED)
    np.testing.assert_allclose(found, cubic_spline(bank, bank.temperature, WANTED), atol=1e-12)


def test_straight_lines_are_straight_lines(filters):
    bank = filters(np.arange(0.0, 61.0, 5.0))
    np.testing.assert_allclose(
        FollowingBank.of_filters(bank, "linear").taps(WANTED), linear(bank, WANTED), atol=1e-12
    )


def test_a_spline_over_another_coordinate_that_falls_with_temperature(filters):
    bank = filters(np.arange(0.0, 61.0, 5.0))
    fine = np.linspace(0.0, 60.0, 241)
    feed = InputMap.of(fine, -0.01 * fine - 1e-5 * fine**2)
    expected = cubic_spline(bank, feed.at(bank.temperature), feed.at(WANTED))
    np.testing.assert_allclose(FollowingBank.of_filters(bank, feed=feed).taps(WANTED), expected, atol=1e-12)


@pytest.mark.parametrize("knots", [[20.0], [10.0, 30.0], [0.0, 20.0, 50.0]])
def test_few_temperatures_give_back_their_own_filters(filters, knots):
    bank = filters(knots)
    found = FollowingBank.of_filters(bank)
    np.testing.assert_allclose(found.taps(bank.temperature), bank.taps, atol=1e-12)
    np.testing.assert_allclose(found.taps([-40.0, 99.0]), bank.taps[[0, -1]], atol=1e-12)
    assert found.temperature_range == (knots[0], knots[-1])


def test_networks_are_the_networks():
    rng = np.random.default_rng(1)
    networks = NetworkBank(
        InputMap.of(np.array([0.0, 60.0]), np.array([0.0, 60.0])),
        rng.standard_normal((2, 5)),
        rng.standard_normal((2, 5)),
        rng.standard_normal((2, 6, 32)),
    )
    found = FollowingBank.of_networks(networks, 8e3, 10)
    np.testing.assert_allclose(found.taps(WANTED), networks.taps(WANTED), atol=1e-12)
    assert found.bank(20.0).delay == 10


def test_principal_filters_are_a_mean_and_splines_of_their_shares(filters):
    bank = filters(np.arange(0.0, 61.0, 5.0))
    mean = bank.taps.mean(axis=0)
    left, values, right = np.linalg.svd((bank.taps - mean).reshape(13, -1), full_matrices=False)
    share, principal = left[:, :4] * values[:4], right[:4].reshape(4, *mean.shape)
    found = FollowingBank.of_principal(bank.temperature, share, principal, mean, 8e3, 12)
    spline = CubicSpline(bank.temperature, share)(np.clip(WANTED, 0.0, 60.0))
    np.testing.assert_allclose(found.taps(WANTED), mean + np.tensordot(spline, principal, axes=1), atol=1e-12)
    assert found.banks.shape == (3, 5, 48)


def test_what_does_not_fit_is_refused(filters):
    bank = filters([0.0, 20.0])
    found = FollowingBank.of_filters(bank)
    with pytest.raises(ValueError, match="one for every weight"):
        FollowingBank(found.input, found.weights, found.banks[:, :1], 8e3, 12)
    with pytest.raises(ValueError, match="not finite"):
        FollowingBank(found.input, found.weights, found.banks * np.nan, 8e3, 12)
    with pytest.raises(ValueError, match="must ascend"):
        FollowingBank.of_filters(FirBank(bank.taps, bank.temperature[::-1], 8e3, 12))
    with pytest.raises(ValueError, match="cubic or linear"):
        FollowingBank.of_filters(bank, "quartic")


def test_sixteen_bits_cost_little_and_never_overflow(filters):
    following = FollowingBank.of_filters(filters(np.arange(0.0, 61.0, 5.0)))
    short = FixedPoint.of(following)
    counts = short.taps(following, WANTED)
    taps = following.taps(WANTED)
    error = np.sum((counts * short.tap_scale - taps) ** 2) / np.sum(taps**2)
    assert 1e-12 < error < 1e-7
    loudest = np.abs(counts.astype(np.int64)).sum(axis=2).max() * 32_768
    assert loudest >> short.shift <= 32_767
    assert loudest >> (short.shift - 1) > 32_767 // 2  # and no bit is given away
    assert short.volts_per_count * 32_767 == pytest.approx(np.abs(taps).sum(axis=2).max(), rel=1.0)
