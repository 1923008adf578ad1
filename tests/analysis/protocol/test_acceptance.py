from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import butter, sosfilt

from analysis.protocol.acceptance import faults
from analysis.protocol.protocol import AcquisitionProtocol
from analysis.protocol.sweep import compare_drive, drive_signal, stretched
from analysis.recordings.campaign import Sweep

RATE = 51_200.0 / 6.0
QUIET = np.zeros(2, dtype=bool)


@pytest.fixture
def protocol(protocol_of: Callable[..., AcquisitionProtocol]) -> AcquisitionProtocol:
    return protocol_of()


@pytest.fixture
def played(protocol: AcquisitionProtocol) -> NDArray[np.float64]:
    return drive_signal(protocol.sweep, 1.0, RATE)


@pytest.fixture
def good(played: NDArray[np.float64]) -> Sweep:
    """Three repeats through a resonance and a card's filter of 38.4 samples, at 10 °C."""
    rng = np.random.default_rng(3)
    grid = np.fft.rfftfreq(played.size)
    delayed = np.fft.irfft(np.fft.rfft(played) * np.exp(-2j * np.pi * grid * 38.4), played.size)
    resonance = butter(1, [400.0, 440.0], btype="bandpass", fs=RATE, output="sos")
    noise = 5e-5 * rng.standard_normal((2, 3, played.size))
    return Sweep(
        step=5,
        direction="up",
        level=1.0,
        oven_temperature_start=10.8,
        oven_temperature_end=10.9,
        start_time="2000-01-01T00:00:00+00:00",
        drive=(delayed + noise[0]).astype(np.float32),
        responses=(0.3 * sosfilt(resonance, delayed) + noise[1]).astype(np.float32)[None],
        plate_temperature_start=9.98,
        plate_temperature_end=10.03,
    )


def fault(
    sweep: Sweep, played: NDArray[np.float64], protocol: AcquisitionProtocol, overload: object = QUIET
) -> str:
    point = protocol.legs[0].set_points[5]
    assert point.temperature == 10.0
    return " | ".join(faults(sweep, played, np.asarray(overload, dtype=bool), RATE, point, protocol))


def test_a_good_sweep_has_no_fault(
    good: Sweep, played: NDArray[np.float64], protocol: AcquisitionProtocol
) -> None:
    assert fault(good, played, protocol) == ""


def test_delay_is_found_to_a_hundredth_of_a_sample(
    good: Sweep, played: NDArray[np.float64], protocol: AcquisitionProtocol
) -> None:
    gain, delay, correlation = compare_drive(good.drive[0], played, RATE, protocol.sweep.frequency_range)
    assert gain == pytest.approx(1.0, abs=1e-3)
    assert delay == pytest.approx(38.4, abs=0.01)
    assert correlation > 0.9999


def test_wrong_temperature(good: Sweep, played: NDArray[np.float64], protocol: AcquisitionProtocol) -> None:
    late = replace(good, plate_temperature_start=10.6, plate_temperature_end=10.65)
    assert "mean temperature 10.62" in fault(late, played, protocol)
    unmeasured = replace(good, plate_temperature_start=None, plate_temperature_end=None)
    assert "mean temperature 10.85" in fault(unmeasured, played, protocol)  # then it is the air that counts


def test_drift(good: Sweep, played: NDArray[np.float64], protocol: AcquisitionProtocol) -> None:
    assert "oven moved by 0.60 K" in fault(replace(good, oven_temperature_end=11.4), played, protocol)
    gone = replace(good, plate_temperature_start=9.6, plate_temperature_end=10.3)
    assert "plate moved by 0.70 K" in fault(gone, played, protocol)


def test_overload(good: Sweep, played: NDArray[np.float64], protocol: AcquisitionProtocol) -> None:
    assert fault(good, played, protocol, [True, False]).startswith("the drive's input is overloaded")
    assert fault(good, played, protocol, [False, True]).startswith("response 1 is overloaded")


@pytest.mark.parametrize("lost", [1, 5, 400])
def test_lost_samples(good: Sweep, played: NDArray[np.float64], protocol: AcquisitionProtocol, lost: int) -> None:
    """A few samples that go missing half way, as a card that overruns without saying so would lose them."""
    drive = good.drive.copy()
    half = drive.shape[1] // 2
    drive[1] = np.concatenate([drive[1, :half], drive[1, half + lost :], np.zeros(lost, np.float32)])
    assert "repeat 2: the drive recorded is not the one played" in fault(
        replace(good, drive=drive), played, protocol
    )


def test_repeats_out_of_step(good: Sweep, played: NDArray[np.float64], protocol: AcquisitionProtocol) -> None:
    drive = good.drive.copy()
    drive[2] = np.roll(drive[2], 1)
    assert "1.00 samples apart" in fault(replace(good, drive=drive), played, protocol)


@pytest.mark.parametrize("difference", [1e-4, -1e-4, 2.9e-4])
def test_clocks_of_their_own_are_no_fault(
    good: Sweep, played: NDArray[np.float64], protocol: AcquisitionProtocol, difference: float
) -> None:
    """An output on another crystal: each repeat is as much longer, and begins at the output's own next edge."""
    drive = good.drive.copy()
    late = stretched(played, difference, RATE, protocol.sweep, 1.0)
    for repeat, delay in enumerate((38.4, 39.1, 38.9)):
        spectrum = np.fft.rfft(late) * np.exp(-2j * np.pi * np.fft.rfftfreq(late.size) * delay)
        drive[repeat] = np.fft.irfft(spectrum, late.size)
    assert fault(replace(good, drive=drive), played, protocol) == ""
    half = drive.shape[1] // 2
    slipped = np.concatenate([drive[1, :half], drive[1, half + 1 :], np.zeros(1, np.float32)])
    assert "repeat 2: the drive recorded is not the one played" in fault(
        replace(good, drive=np.stack([drive[0], slipped, drive[2]])), played, protocol
    )
    apart = np.stack([drive[0], np.roll(drive[1], 2), drive[2]])
    assert "they are not synchronous" in fault(replace(good, drive=apart), played, protocol)


def test_clocks_that_differ_by_more_than_crystals_do_are_a_fault(
    good: Sweep, played: NDArray[np.float64], protocol: AcquisitionProtocol
) -> None:
    """A sample rate that is not the one asked for, 0.3 % off."""
    wrong = stretched(played, 3e-3, RATE, protocol.sweep, 1.0).astype(np.float32)
    fault_of_it = fault(replace(good, drive=np.stack([wrong, wrong, wrong])), played, protocol)
    assert "repeat 1: the drive recorded is not the one played" in fault_of_it


def test_drive_of_another_level_or_none(
    good: Sweep, played: NDArray[np.float64], protocol: AcquisitionProtocol
) -> None:
    assert "0.900 times the level" in fault(replace(good, drive=np.float32(0.9) * good.drive), played, protocol)
    assert "correlation" in fault(replace(good, drive=np.zeros_like(good.drive)), played, protocol)


def test_silence(good: Sweep, played: NDArray[np.float64], protocol: AcquisitionProtocol) -> None:
    noise = 5e-5 * np.random.default_rng(1).standard_normal(good.responses.shape)
    assert "response 1 is silent" in fault(replace(good, responses=noise.astype(np.float32)), played, protocol)
    assert "response 1 is silent" in fault(
        replace(good, responses=np.full_like(good.responses, np.nan)), played, protocol
    )


def test_a_response_that_has_nothing_to_do_with_the_drive(
    good: Sweep, played: NDArray[np.float64], protocol: AcquisitionProtocol
) -> None:
    noise = 0.1 * np.random.default_rng(1).standard_normal(good.responses.shape)
    assert "not coherent over the repeats" in fault(
        replace(good, responses=noise.astype(np.float32)), played, protocol
    )


def test_a_force_need_not_be_the_voltage_played_but_the_same_in_every_repeat(
    good: Sweep, played: NDArray[np.float64], protocol: AcquisitionProtocol
) -> None:
    """An exciter on a resonance: its force is a tenth of the voltage, and nothing like it."""
    notch = butter(1, [300.0, 600.0], btype="bandstop", fs=RATE, output="sos")
    force = replace(good, drive=(0.1 * sosfilt(notch, good.drive)).astype(np.float32))
    forced = replace(protocol, measured_force=True)
    assert "not the one played" in fault(force, played, protocol)
    assert fault(force, played, forced) == ""
    slipped = force.drive.copy()
    slipped[1, slipped.shape[1] // 3 : -40] = slipped[1, slipped.shape[1] // 3 + 40 :]
    assert "repeat 2: the force is not that of repeat 1" in fault(replace(force, drive=slipped), played, forced)
    louder = force.drive * np.float32([[1.0], [1.0], [1.1]])
    assert "1.100 times the level of repeat 1" in fault(replace(force, drive=louder), played, forced)
    assert "the force is silent" in fault(replace(force, drive=np.float32(1e-4) * force.drive), played, forced)
