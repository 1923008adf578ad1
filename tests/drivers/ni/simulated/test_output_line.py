import numpy as np
import pytest

from drivers.ni.modules import NI_9260, NI_9263
from drivers.ni.simulated.chassis import OutputLine


def test_holds_the_last_value() -> None:
    line = OutputLine(NI_9260)
    assert line.voltage(5.0) == 0.0
    line.play(np.array([1.0, 2.0, 3.0]), 10.0, 5.0)
    assert line.voltages(np.array([4.99, 5.0, 5.05, 5.1, 5.2, 5.31, 99.0])) == pytest.approx(
        [0.0, 1.0, 1.0, 2.0, 3.0, 3.0, 3.0], abs=1e-6
    )


def test_stopping_keeps_the_voltage_of_that_moment() -> None:
    line = OutputLine(NI_9260)
    line.play(np.array([1.0, 2.0, 3.0]), 10.0, 5.0)
    line.stop(5.15)
    assert line.voltages(np.array([5.05, 5.16, 6.0])) == pytest.approx([1.0, 2.0, 2.0], abs=1e-6)


def test_repeats_until_stopped() -> None:
    line = OutputLine(NI_9260)
    line.play(np.array([1.0, -1.0]), 10.0, 0.0, repeats=True)
    assert [line.voltage(moment) for moment in (0.05, 0.15, 100.05)] == pytest.approx([1.0, -1.0, 1.0], abs=1e-6)


def test_an_input_of_nearly_the_same_pace_sees_no_stairs() -> None:
    """Two crystals 100 ppm apart: what comes is the tone itself, not one that loses a sample now and then."""
    rate = 51_200.0
    line = OutputLine(NI_9260)
    line.play(np.sin(2.0 * np.pi * 7000.0 * np.arange(30_000) / rate), rate, 0.0)
    moments = np.arange(100, 29_000) / (rate * (1.0 - 1e-4))
    assert line.voltages(moments) == pytest.approx(np.sin(2.0 * np.pi * 7000.0 * moments), abs=2e-3)


def test_is_rounded_to_codes_and_limited_to_the_range() -> None:
    line = OutputLine(NI_9263)
    line.play(np.array([1.0, 99.0]), 1.0, 0.0)
    assert line.voltage(0.5) == pytest.approx(round(1.0 / NI_9263.quantum) * NI_9263.quantum, rel=1e-12)
    assert line.voltage(0.5) != 1.0
    assert line.voltage(2.0) == 10.0


def test_samples_of_one_grid_stay_on_it_after_hours() -> None:
    """Moments counted from another start must not fall on the sample before."""
    rate, start = 51_200.0 / 6.0, 10_800.123
    line = OutputLine(NI_9260)
    played = np.linspace(-1.0, 1.0, 50_000)
    line.play(played, rate, start)
    moments = (start - 8533 / rate) + np.arange(50_000 + 8533) / rate
    found = line.voltages(moments)[-(50_000 - 8533) :]
    first = np.argmin(np.abs(played - found[0]))
    assert found == pytest.approx(played[first : first + found.size], abs=1e-6)


def test_forgets_what_is_past_and_nothing_else() -> None:
    line = OutputLine(NI_9260)
    for start in range(100):
        line.play(np.array([float(start % 4)]), 1.0, float(start))
    version = line.version
    line.forget_before(98.5)
    assert len(line._runs) == 2
    assert line.version == version
    assert line.voltage(98.7) == pytest.approx(2.0, abs=1e-6)
    assert line.voltage(99.5) == pytest.approx(3.0, abs=1e-6)
