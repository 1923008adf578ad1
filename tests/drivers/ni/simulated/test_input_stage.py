import numpy as np
import pytest

from drivers.ni.modules import NI_9234
from drivers.ni.simulated.acquisition import coupled, delay_taps, delayed, digitised

RATES = [51_200.0, 51_200.0 / 6.0, 51_200.0 / 31.0]


@pytest.mark.parametrize("rate", RATES)
def test_delay_is_that_of_the_data_sheet_and_the_band_is_flat(rate: float) -> None:
    taps = delay_taps(NI_9234, rate)
    frequency = np.linspace(0.001, 0.42, 200) * rate
    response = np.exp(-2j * np.pi * np.outer(frequency, np.arange(taps.size)) / rate) @ taps
    assert np.abs(20.0 * np.log10(np.abs(response))).max() < 0.04  # the data sheet's flatness, dB
    late = -np.unwrap(np.angle(response)) / (2.0 * np.pi * frequency)
    assert np.abs(late - NI_9234.delay(rate)).max() < 2e-3 / rate


def test_nothing_comes_before_its_cause() -> None:
    step = np.zeros((1, 200))
    step[0, 100:] = 1.0
    assert np.abs(delayed(step, NI_9234, 51_200.0)[0, :100]).max() < 1e-12


def test_coupling_has_its_corner_where_it_should() -> None:
    rate = 2048.0
    time = np.arange(int(40.0 * rate)) / rate
    for frequency in (0.05, 0.5, 5.0):
        passed = coupled(np.sin(2.0 * np.pi * frequency * time), 0.5, rate)
        settled = time >= 20.0  # a whole number of periods of each
        level = np.abs(2.0 * np.mean(passed[settled] * np.exp(-2j * np.pi * frequency * time[settled])))
        first_order = frequency / np.hypot(frequency, 0.5)
        assert level == pytest.approx(first_order, rel=0.02)


def test_noise_is_white_and_of_the_size_given() -> None:
    noise = digitised(np.zeros((3, 100_000)), NI_9234, np.random.default_rng(1))
    assert np.std(noise, axis=1) == pytest.approx(50e-6, rel=0.02)
    neighbours = np.mean(noise[:, 1:] * noise[:, :-1], axis=1) / np.var(noise, axis=1)
    assert np.abs(neighbours).max() < 0.02
    assert np.abs(np.corrcoef(noise) - np.eye(3)).max() < 0.02


def test_clipping_and_codes() -> None:
    quantum = NI_9234.quantum
    codes = digitised(np.array([[-9.0, 9.0, 0.0]]), NI_9234, np.random.default_rng(1)) / quantum
    assert codes[0, 0] == -(2**23)
    assert codes[0, 1] == 2**23 - 1
    assert np.array_equal(codes, np.round(codes))


def test_longer_record_begins_like_a_shorter_one() -> None:
    short = digitised(np.zeros((2, 50)), NI_9234, np.random.default_rng(5))
    long = digitised(np.zeros((2, 500)), NI_9234, np.random.default_rng(5))
    assert np.array_equal(long[:, :50], short)
