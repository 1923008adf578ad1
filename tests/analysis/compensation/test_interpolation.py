from dataclasses import replace

import numpy as np
import pytest

from analysis.compensation.network import relative_error
from analysis.compensation.rivals import cubic_spline, linear, log_root_rigidity, reduced_frequency
from analysis.focusing.fir import FirBank


def polynomial(temperature, degree, taps=5):
    coefficient = np.arange(1.0, degree + 2)[:, None, None] * np.linspace(0.5, 2.0, 2 * taps).reshape(2, taps)
    powers = (np.asarray(temperature)[:, None] / 30.0) ** np.arange(degree + 1)
    return np.einsum("tp,pnm->tnm", powers, coefficient)


@pytest.fixture
def wanted():
    return np.arange(0.0, 60.1, 0.25)


@pytest.mark.parametrize(("method", "degree"), [("linear", 1), ("cubic", 3)])
def test_each_is_exact_on_its_own_polynomials_and_not_beyond(method, degree, wanted):
    knots = np.arange(0.0, 61.0, 5.0)

    def error(order):
        bank = FirBank(polynomial(knots, order), knots, 8_000.0, 0)
        found = linear(bank, wanted) if method == "linear" else cubic_spline(bank, knots, wanted)
        return np.abs(found / polynomial(wanted, order) - 1.0).max()

    assert error(degree) < 1e-12
    assert error(degree + 1) > 1e-6


def test_all_pass_through_the_training_filters(thirteen):
    knots = thirteen.temperature
    np.testing.assert_allclose(linear(thirteen, knots), thirteen.taps, atol=1e-18)
    np.testing.assert_allclose(cubic_spline(thirteen, knots, knots), thirteen.taps, atol=1e-17)
    np.testing.assert_allclose(cubic_spline(thirteen, -knots, -knots), thirteen.taps, atol=1e-17)


def test_the_spline_converges_with_the_fourth_order(tones, wanted):
    def error(spacing):
        knots = np.arange(0.0, 61.0, spacing)
        bank = FirBank(tones(knots), knots, 8_000.0, 16)
        return np.sqrt(relative_error(cubic_spline(bank, knots, wanted), tones(wanted)).max())

    assert 12.0 < error(5.0) / error(2.5) < 20.0


def test_both_hold_the_end_outside_the_range(thirteen):
    beyond = np.array([-5.0, 70.0])
    for found in (linear(thirteen, beyond), cubic_spline(thirteen, thirteen.temperature, beyond)):
        np.testing.assert_allclose(found, thirteen.taps[[0, -1]], atol=1e-17)


def test_the_rigidity_s_logarithm():
    u = log_root_rigidity(np.array([1.0e9, 4.0e9]), np.array([0.3, 0.3]))
    assert np.diff(u).item() == pytest.approx(np.log(2.0))


@pytest.mark.parametrize("delay", [0, 16, 31])
def test_at_the_training_temperatures_equal_reduced_frequency_gives_their_responses(thirteen, delay):
    """To rounding, wherever the taps' middle lies: the series of a response ends where nothing is left of it."""
    bank = replace(thirteen, delay=delay)
    u, frequency = np.linspace(0.3, 0.0, 13), np.arange(20.0, 900.0, 7.0)
    exact = bank.response(frequency)
    found = reduced_frequency(bank, u, u, frequency)
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-11 * np.abs(exact).max())


def test_a_single_line_of_a_single_temperature_has_its_own_response(thirteen):
    bank = replace(thirteen, taps=thirteen.taps[:1], temperature=thirteen.temperature[:1])
    line = np.array([300.0])
    np.testing.assert_allclose(reduced_frequency(bank, np.zeros(1), np.zeros(1), line), bank.response(line))


def test_filters_of_one_reduced_frequency_are_met_exactly():
    """R(f, D) = D g(f/√D): taps sampled from one impulse response, stretched, leave nothing to interpolate."""
    rate, count = 8_000.0, 800
    u = np.log(np.linspace(1.8, 1.0, 5))  # √D falls with temperature
    frequency = np.arange(60.0, 800.0, 2.0)

    def taps(v):
        """g(t) decays within the taps; its spectrum at f e^-v belongs to e^v g(t e^v), times e^2v."""
        time = np.arange(count) / rate * np.exp(v)
        return np.exp(3.0 * v) * time**3 * np.exp(-time / 0.004) * np.cos(2.0 * np.pi * 300.0 * time)

    bank = FirBank(np.array([taps(v) for v in u])[:, None], np.linspace(0.0, 60.0, 5), rate, 0)
    places = np.array([u[0], u[2], 0.5 * (u[1] + u[2]), u[4]])
    found = reduced_frequency(bank, u, places, frequency)
    wanted = FirBank(np.array([taps(v) for v in places])[:, None], np.arange(4.0), rate, 0)
    exact = wanted.response(frequency)
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-5 * np.abs(exact).max())
