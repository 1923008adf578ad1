"""The simulated rig's plate against an oscillator integrated in time while its stiffness drifts."""

from dataclasses import dataclass, field

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.material import Material, laws_through
from analysis.protocol.sweep import SweepSettings, drive_signal
from analysis.recordings.sweep_point import SweepPoint
from app.rig.simulated_plate import Followed, TwinPlate

RATE = 51_200.0 / 6.0
DAMPING = 0.03
SWEEP = SweepSettings(
    kind="logarithmic", band=(100.0, 1500.0), duration=2.0, taper=0.1, tail=0.4, repeats=1, levels=(1.0,)
)
T = np.linspace(0.0, 40.0, 5)
LAWS = laws_through(T, Material(3e9 * np.exp(-0.02 * T), np.full(5, 0.35), np.full(5, 0.05)))


def natural(youngs_modulus: float) -> float:
    """Angular frequency of the oscillator, rad/s: 400 Hz at 3 GPa."""
    return float(2.0 * np.pi * 400.0 * np.sqrt(youngs_modulus / 3e9))


@dataclass
class Oscillator:
    """An oscillator of unit static response; remembers in which circumstances it was asked."""

    follows: Followed = frozenset()
    band: tuple[float, float] = (100.0, 1500.0)
    outputs: int = 1
    asked: list[SweepPoint] = field(default_factory=list)

    def __call__(self, point: SweepPoint, frequency: Real) -> NDArray[np.complex128]:
        self.asked.append(point)
        own = natural(float(LAWS.at(point.temperature).youngs_modulus[0]))
        omega = 2.0 * np.pi * frequency
        return np.asarray(own**2 / (own**2 - omega**2 + 2j * DAMPING * own * omega), dtype=np.complex128)[None]


@pytest.fixture
def plate() -> TwinPlate:
    """Return a plate that is an oscillator behind an amplifier of 2 V/V."""
    return TwinPlate(Oscillator(), 2.0)


def integrated(temperature: Real) -> Real:
    """Solve y'' + 2 z w(T) y' + w(T)**2 y = w(T)**2 u by the classical Runge-Kutta method, four steps a sample."""
    fine = 8  # two evaluations of the drive for each step
    drive = 2.0 * drive_signal(SWEEP, 1.0, fine * RATE)
    own = np.interp(np.arange(drive.size) / fine, np.arange(temperature.size), _natural_over(temperature))
    step, state, answer = 2.0 / (fine * RATE), np.zeros(2), np.empty(temperature.size)

    def slope(at: int, y: Real) -> Real:
        at = min(at, drive.size - 1)
        w = own[at]
        return np.array([y[1], w * w * (drive[at] - y[0]) - 2.0 * DAMPING * w * y[1]])

    for sample in range(temperature.size):
        answer[sample] = state[0]
        for begin in range(fine * sample, fine * (sample + 1), 2):
            k1 = slope(begin, state)
            k2 = slope(begin + 1, state + 0.5 * step * k1)
            k3 = slope(begin + 1, state + 0.5 * step * k2)
            k4 = slope(begin + 2, state + step * k3)
            state = state + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return answer


def _natural_over(temperature: Real) -> Real:
    nodes = np.linspace(temperature.min(), temperature.max() + 1e-9, 50)
    values = [natural(float(LAWS.at(node).youngs_modulus[0])) for node in nodes]
    return np.interp(temperature, nodes, values)


def in_band(signal: Real) -> NDArray[np.complex128]:
    grid = np.fft.rfftfreq(signal.size, 1.0 / RATE)
    return np.fft.rfft(signal)[(grid > 110.0) & (grid < 1400.0)]


@pytest.mark.parametrize("drift", [0.0, 0.016, 0.35])
def test_answers_as_the_oscillator_does(plate: TwinPlate, drift: float) -> None:
    """At rest, at the paper's 0.4 K/min, and through several nodes in one record."""
    drive = drive_signal(SWEEP, 1.0, RATE)
    temperature = 20.03 + drift * np.arange(drive.size) / drive.size
    answer = plate(drive, RATE, temperature)
    assert answer.shape == (1, drive.size)
    truth = integrated(temperature)
    error = np.linalg.norm(in_band(answer[0]) - in_band(truth)) / np.linalg.norm(in_band(truth))
    assert error < 2e-3
    if drift > 0.1:  # and a plate that did not drift would be told apart
        still = plate(drive, RATE, np.full(drive.size, 20.03))
        assert np.linalg.norm(in_band(still[0]) - in_band(truth)) / np.linalg.norm(in_band(truth)) > 2 * error


def test_between_two_nodes_a_resonance_is_as_high_as_at_them(plate: TwinPlate) -> None:
    drive = drive_signal(SWEEP, 1.0, RATE)
    grid = np.fft.rfftfreq(drive.size, 1.0 / RATE)
    lines = grid[(grid > 110.0) & (grid < 1400.0)]
    for temperature in (20.0, 20.03, 20.1, 20.17):
        answer = plate(drive, RATE, np.full(drive.size, temperature))
        steady = Oscillator()(SweepPoint(temperature, 0.0, 1.0), lines)[0]
        found = in_band(answer[0]) / in_band(2.0 * drive)
        assert np.abs(found - steady).max() < 1e-4 * np.abs(steady).max()


def test_each_frequency_is_measured_at_the_temperature_at_its_time() -> None:
    """The FRF of a record is that at steady temperatures, at each line the one when the sweep passed it."""
    drive, rate = drive_signal(SWEEP, 1.0, RATE), 0.02
    temperature = 20.0 + rate * (np.arange(drive.size) / RATE - 0.5 * SWEEP.record)
    grid = np.fft.rfftfreq(drive.size, 1.0 / RATE)
    lines = grid[(grid > 110.0) & (grid < 1400.0)]
    found = in_band(integrated(temperature)) / in_band(2.0 * drive)

    def apart(temperature: Real) -> float:
        oscillator = Oscillator()
        pairs = zip(temperature, lines, strict=True)
        steady = [oscillator(SweepPoint(float(t), 0.0, 1.0), np.array([f]))[0, 0] for t, f in pairs]
        return float(np.abs(found - steady).max() / np.abs(found).max())

    away = rate * SWEEP.timing.after_middle(lines)
    assert apart(20.0 + away) < 0.2 * apart(np.full(lines.size, 20.0))


def test_depends_on_what_it_is_given_only(plate: TwinPlate) -> None:
    """Whatever was asked before: a campaign that is taken up again meets the same plate."""
    drive = drive_signal(SWEEP, 1.0, RATE)
    first = plate(drive, RATE, np.full(drive.size, 20.03))
    for other in (3.0, 11.0, 25.0, 31.0, 38.0):
        plate(drive, RATE, np.full(drive.size, other))
    np.testing.assert_array_equal(plate(drive, RATE, np.full(drive.size, 20.03)), first)
    np.testing.assert_allclose(
        plate(3.0 * drive, RATE, np.full(drive.size, 20.03)), 3.0 * first, rtol=1e-9, atol=1e-12
    )


def test_effects_meet_the_rate_of_the_record_and_the_level_of_the_drive() -> None:
    """Signed by the direction, K/s; before the amplifier, V."""
    drive = drive_signal(SWEEP, 1.5, RATE)
    seconds = np.arange(drive.size) / RATE
    for kelvin_per_minute in (0.4, -1.0):
        asked = Oscillator(frozenset({"rate", "level"}))
        TwinPlate(asked, 2.0)(drive, RATE, 20.03 + kelvin_per_minute / 60.0 * seconds)
        assert asked.asked
        for point in asked.asked:
            assert point.level == pytest.approx(np.abs(drive).max(), rel=5e-3)
            assert point.rate == pytest.approx(kelvin_per_minute / 60.0, abs=6e-6)


def test_what_follows_the_level_alone_is_asked_once_for_all_rates() -> None:
    drive = drive_signal(SWEEP, 1.5, RATE)
    asked = Oscillator(frozenset({"level"}))
    plate = TwinPlate(asked, 2.0)
    for kelvin in (0.01, -0.02):
        plate(drive, RATE, 20.03 + np.linspace(0.0, kelvin, drive.size))
    assert {point.rate for point in asked.asked} == {0.0}
    assert len(asked.asked) == 4
    assert asked.asked[0].level == pytest.approx(np.abs(drive).max(), rel=5e-3)


def test_where_nothing_follows_them_one_response_serves_every_rate_and_level(plate: TwinPlate) -> None:
    drive = drive_signal(SWEEP, 1.0, RATE)
    plate(drive, RATE, 20.03 + np.linspace(0.0, 0.01, drive.size))
    plate(2.0 * drive, RATE, 20.03 - np.linspace(0.0, 0.01, drive.size))
    assert isinstance(plate.transfer, Oscillator)
    assert [point.temperature for point in plate.transfer.asked] == [19.8, 20.0, 20.2, 20.4]


def test_a_plate_at_rest_stays_silent(plate: TwinPlate) -> None:
    assert not plate(np.zeros(100), RATE, np.full(100, 20.0)).any()
