"""Effects on what the signals pass through, against the definitions of ``recorded-campaign/1`` by hand."""

import numpy as np
import pytest

from simulation.effects.library import LIBRARY, apply_all


def factor(state):
    """Return what every response is multiplied by."""
    return np.exp(state.log_gain + 1j * state.phase)


@pytest.mark.parametrize(("temperature", "expected"), [(25.0, 1.0), (60.0, 1.0525), (5.0, 0.97)])
def test_piezo_drift_is_linear_in_the_ovens_temperature(trial, temperature, expected):
    circumstances, state = trial(temperature=temperature, rate=0.01)
    values = {"thermal_lag": {"tau": 500.0}, "piezo_drift": {"alpha": 0.0015}}
    after = apply_all(LIBRARY, state, circumstances, values)
    np.testing.assert_allclose(factor(after), expected, rtol=1e-14)


def test_drift_never_turns_a_response_round_at_temperatures_that_may_be_declared(experiment, trial):
    (alpha,) = LIBRARY["piezo_drift"].card(experiment).parameters
    for temperature in (-80.0, 200.0):
        circumstances, state = trial(temperature=temperature)
        for value in (alpha.low, alpha.high):
            after = LIBRARY["piezo_drift"].apply(state, circumstances, {"alpha": value})
            assert factor(after).real.min() > 0.0


def test_a_late_response_lags_by_frequency_times_delay(trial):
    circumstances, state = trial(frequency=(250.0, 1000.0))
    after = LIBRARY["channel_skew"].apply(state, circumstances, {"delay": 1e-4})
    np.testing.assert_allclose(np.degrees(np.angle(factor(after))), [-9.0, -36.0], rtol=1e-12)
    np.testing.assert_array_equal(after.log_gain, 0.0)


def test_a_skewed_sine_is_the_sine_of_an_earlier_moment(trial):
    circumstances, state = trial(frequency=(400.0,))
    after = LIBRARY["channel_skew"].apply(state, circumstances, {"delay": 2e-4})
    time = np.linspace(0.0, 0.01, 50)
    late = np.imag(factor(after)[0] * np.exp(2j * np.pi * 400.0 * time))
    np.testing.assert_allclose(late, np.sin(2.0 * np.pi * 400.0 * (time - 2e-4)), atol=1e-13)


def test_a_high_pass_leaves_three_decibels_less_and_45_degrees_more_at_its_corner(trial):
    circumstances, state = trial(frequency=(10.0, 1e6))
    passed = factor(LIBRARY["high_pass"].apply(state, circumstances, {"corner": 10.0}))
    assert 20.0 * np.log10(np.abs(passed[0])) == pytest.approx(-3.0103, abs=1e-4)
    assert np.degrees(np.angle(passed[0])) == pytest.approx(45.0)
    assert passed[1] == pytest.approx(1.0, abs=2e-5)


def test_a_high_pass_is_its_transfer_function(trial):
    frequency = np.array([5.0, 40.0, 300.0])
    circumstances, state = trial(frequency=tuple(frequency))
    passed = factor(LIBRARY["high_pass"].apply(state, circumstances, {"corner": 33.0}))
    np.testing.assert_allclose(passed, 1j * frequency / (1j * frequency + 33.0), rtol=1e-13)


def test_response_effects_multiply(trial):
    circumstances, state = trial(temperature=45.0, frequency=(150.0, 700.0))
    values = {"piezo_drift": {"alpha": 2e-3}, "channel_skew": {"delay": -5e-5}, "high_pass": {"corner": 20.0}}
    together = factor(apply_all(LIBRARY, state, circumstances, values))
    apart = [factor(LIBRARY[name].apply(state, circumstances, own)) for name, own in values.items()]
    np.testing.assert_allclose(together, np.prod(apart, axis=0), rtol=1e-13)


def test_feedthrough_is_added_beside_the_factor_not_through_it(trial):
    circumstances, state = trial()
    values = {"feedthrough": {"gain": 3e-4}, "channel_skew": {"delay": 1e-4}, "piezo_drift": {"alpha": 1e-3}}
    after = apply_all(LIBRARY, state, circumstances, values)
    assert after.feedthrough == 3e-4
    without = apply_all(LIBRARY, state, circumstances, {k: v for k, v in values.items() if k != "feedthrough"})
    np.testing.assert_array_equal(factor(after), factor(without))


def test_a_low_pass_is_its_transfer_function(trial):
    frequency = np.array([100.0, 1000.0, 1e4])
    circumstances, state = trial(frequency=tuple(frequency))
    passed = factor(LIBRARY["low_pass"].apply(state, circumstances, {"time_constant": 1e-4}))
    np.testing.assert_allclose(passed, 1.0 / (1.0 + 2e-4j * np.pi * frequency), rtol=1e-13)


def test_a_low_pass_is_at_first_a_delay_and_weakens_then(trial):
    """Its slope at zero is that of a delay, the rest is of second order: only large ones are told apart."""
    circumstances, state = trial(frequency=(100.0, 1500.0))
    low, late = (
        factor(LIBRARY[name].apply(state, circumstances, {key: 1e-30j}))
        for name, key in (("low_pass", "time_constant"), ("channel_skew", "delay"))
    )
    np.testing.assert_allclose(low, late, rtol=1e-14)
    strong = LIBRARY["low_pass"].apply(state, circumstances, {"time_constant": 1e-4})
    assert strong.log_gain[1] == pytest.approx(-0.5 * np.log(1.0 + (2e-4 * np.pi * 1500.0) ** 2))


def test_crosstalk_is_what_a_mutual_inductance_adds(trial):
    """Volts j w M I per volt V with I = V/Z: M/Z = 1 microsecond makes pi mV/V at 500 Hz."""
    frequency = np.array([100.0, 500.0, 2000.0])
    circumstances, state = trial(frequency=tuple(frequency))
    after = LIBRARY["crosstalk"].apply(state, circumstances, {"gain": np.pi * 1e-3})
    np.testing.assert_allclose(1j * after.crosstalk, 2j * np.pi * frequency * 1e-6, rtol=1e-13)
    assert after.feedthrough == 0.0


@pytest.mark.parametrize("level", [1.0, 2.0])
def test_a_patch_after_rayleigh_traces_his_loop(trial, level):
    """S = (d + a E_0) E +- a (E_0**2 - E**2)/2: the first harmonic of the loop is the effect's factor."""
    beta, turns = 0.03, np.linspace(0.0, 2.0 * np.pi, 200_001)[:-1]
    field, rising = level * np.cos(turns), np.sin(turns) < 0.0
    branch = np.where(rising, -1.0, 1.0) * 0.5 * beta * (level**2 - field**2)
    strain = (1.0 + beta * level) * field + branch
    first = 2.0 * np.mean(strain * np.exp(-1j * turns)) / level
    circumstances, state = trial(level=level)
    after = LIBRARY["piezo_nonlinearity"].apply(state, circumstances, {"beta": beta})
    np.testing.assert_allclose(factor(after), first, rtol=1e-6)


def test_a_loss_angle_is_alike_at_all_frequencies(trial):
    circumstances, state = trial(frequency=(100.0, 1500.0))
    after = LIBRARY["piezo_loss"].apply(state, circumstances, {"angle": 0.03})
    np.testing.assert_allclose(factor(after), np.exp(-0.03j), rtol=1e-14)


def test_heat_weakens_the_way_down_only(trial):
    for rate, expected in ((0.01, 1.0), (0.0, 1.0), (-0.01, 0.93)):
        circumstances, state = trial(rate=rate)
        after = LIBRARY["depolarization"].apply(state, circumstances, {"lost": 0.07})
        np.testing.assert_allclose(factor(after), expected, rtol=1e-14)


def test_a_soft_mount_reads_too_much_by_the_law_of_its_oscillator(accelerometers, trial):
    """A sensor on a spring resonating at three times the band's end: 1/(1 - (f/f_m)**2)."""
    frequency = np.array([300.0, 900.0, 1500.0])
    circumstances, state = trial(frequency=tuple(frequency), declared=accelerometers)
    after = LIBRARY["mounting_resonance"].apply(state, circumstances, {"softness": 1.0 / 9.0})
    np.testing.assert_allclose(factor(after), 1.0 / (1.0 - (frequency / 4500.0) ** 2), rtol=1e-13)


def test_the_capacitance_grows_with_the_plates_temperature(trial):
    circumstances, state = trial(temperature=45.0, rate=0.01)
    values = {"thermal_lag": {"tau": 500.0}, "permittivity_drift": {"beta": 0.004}}
    after = apply_all(LIBRARY, state, circumstances, values)
    assert after.departures.permittivity == pytest.approx(1.0 + 0.004 * 15.0)


def test_a_leak_lies_beside_the_input(trial):
    """1/R = 1/R_in + 1/R_leak, and the leak's conductance doubles every ten kelvins."""
    circumstances, state = trial(temperature=45.0)
    after = LIBRARY["insulation_leak"].apply(state, circumstances, {"leak25": 0.1, "growth": np.log(2.0) / 10.0})
    both = 1.0 / (1.0 / 305e3 + 4.0 * 0.1 / 305e3)
    assert 305e3 * after.departures.resistance == pytest.approx(both)
