"""Rates by times and steps: as exact as their digits, and never across a gap."""

import numpy as np
import pytest

from analysis.estimation.sampling import LARGEST_RATE_ERROR, of_step, of_times, settled

RATES = (1000.0, 1024.0, 2048.0, 4096.0, 12800.0, 51200.0, 1651.6129)


def rounded(time: np.ndarray, form: str) -> np.ndarray:
    return np.array([float(form.format(t)) for t in time])


@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize("form", ["{:.6f}", "{:.5e}", "{:.9g}", "{:.17g}"])
def test_a_rate_is_known_to_its_digits(rate: float, form: str) -> None:
    seen = of_times(rounded(np.arange(20000) / rate, form))
    assert seen.rate == pytest.approx(rate, rel=1e-6)
    assert abs(seen.rate / rate - 1.0) <= seen.error + 1e-8
    assert settled([seen]) == seen.rate


@pytest.mark.parametrize("offset", [0.0, 3.8e9])
def test_times_of_three_decimals_tell_1024_hz(offset: float) -> None:
    """The rounding differs from sample to sample, and the fit through all of them does not."""
    assert of_times(np.round(offset + np.arange(8192) / 1024.0, 3)).rate == pytest.approx(1024.0, rel=1e-6)


@pytest.mark.parametrize("count", [300, 61440, 500_000])
@pytest.mark.parametrize("lost", [1, 3, 100])
@pytest.mark.parametrize("form", [None, 6])
def test_no_sample_may_be_missing_however_long_the_record(count: int, lost: int, form: int | None) -> None:
    time = np.delete(np.arange(count + lost) / 1024.0, np.s_[count // 2 : count // 2 + lost])
    time = time if form is None else np.round(time, form)
    with pytest.raises(ValueError, match=f"not evenly spaced.* about {lost} samples are missing"):
        of_times(time)


def test_times_that_drift_are_no_constant_rate() -> None:
    time = np.arange(60000) / 1000.0
    with pytest.raises(ValueError, match=r"not evenly spaced: at .* samples off a constant rate"):
        of_times(time + 1e-6 * time**2)


@pytest.mark.parametrize(
    "time", [np.arange(800) // 2, np.zeros(9), np.arange(9)[::-1], np.array([0.0, np.nan, 1])]
)
def test_what_is_no_course_of_time(time: np.ndarray) -> None:
    with pytest.raises(ValueError, match=r"times do not rise|not finite"):
        of_times(time.astype(float))


@pytest.mark.parametrize(
    ("written", "rate"),
    [
        ("0.000977", None), ("0.000488", None), ("0.000244", None), ("0.000020", None), ("0,000977", None),
        ("0.001000", 1000.0), ("0.000500", 2000.0), ("0.000050", 20000.0), ("9.765625E-4", 1024.0),
        ("4.8828125D-4", 2048.0), ("0.0009765625", 1024.0), ("0.001", 1000.0),
    ],
)  # fmt: skip
def test_a_step_of_few_digits_is_told_from_an_exact_one(written: str, rate: float | None) -> None:
    """0.000020 is 50 kHz, or 51.2 kHz of another converter."""
    step = float(written.replace(",", ".").replace("D", "E"))
    seen = of_step(step, "Delta_X", written)
    if rate is None:
        assert seen.error > LARGEST_RATE_ERROR
        with pytest.raises(ValueError, match=r"Delta_X = .* has too few digits.* declare sample_rate"):
            settled([seen])
    else:
        assert (settled([seen]), seen.error) == (pytest.approx(rate, rel=1e-12), 0.0)


@pytest.mark.parametrize("rate", [1000.0, 1024.0, 25600.0, 44100.0, 1 / 0.0015, 781.25, 1 / 3e-4])
def test_binary_steps_that_are_exact(rate: float) -> None:
    assert settled([of_step(1.0 / rate, "wf_increment")]) == pytest.approx(rate, rel=1e-9)


def test_rounded_step_and_times_agree_and_a_wrong_one_does_not() -> None:
    times = of_times(np.round(np.arange(8192) / 1024.0, 6), "its times")
    assert settled([of_step(0.000977, "Delta_X", "0.000977"), times]) == times.rate
    with pytest.raises(
        ValueError, match=r"two sample rates: 1024\S* Hz by its times and 1000 Hz by Delta_X = 0.001000"
    ):
        settled([times, of_step(0.001, "Delta_X", "0.001000")])
