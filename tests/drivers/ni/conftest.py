"""A filter for a plate, wired to simulated cards."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.signal import butter, sosfilt, sosfreqz

from analysis.arrays import Real
from drivers.ni.daqmx import DaqmxCards
from drivers.ni.simulated.servicer import InProcessChannel, SimulatedDaq
from drivers.ni.simulated.surroundings import Surroundings
from drivers.ni.wiring import Wiring


class FilterPlate:
    """Two sensors: a band-pass of second order, and the drive halved and turned over."""

    def __init__(self) -> None:
        self.before: Callable[[], None] = lambda: None
        self.seen: list[tuple[int, float]] = []
        self.temperature: Real = np.empty(0)

    @staticmethod
    def sections(sample_rate: float) -> Real:
        return np.asarray(butter(1, [300.0, 900.0], btype="bandpass", fs=sample_rate, output="sos"))

    def response(self, frequency: Real, sample_rate: float) -> Real:
        """(2, F) what it does to a tone, at the rate it is computed at."""
        _, first = sosfreqz(self.sections(sample_rate), worN=frequency, fs=sample_rate)
        return np.stack([first, np.full_like(first, -0.5)])

    def __call__(self, drive: Real, sample_rate: float, temperature: Real) -> Real:
        self.before()
        self.seen.append((drive.size, sample_rate))
        self.temperature = temperature
        return np.stack([sosfilt(self.sections(sample_rate), drive), -0.5 * drive])


@pytest.fixture
def plate() -> FilterPlate:
    return FilterPlate()


@pytest.fixture
def surroundings(plate: FilterPlate) -> Surroundings:
    return Surroundings(plate, {"cDAQ1Mod1/ai1": 0, "cDAQ1Mod1/ai2": 1})


@pytest.fixture
def server(surroundings: Surroundings) -> SimulatedDaq:
    return SimulatedDaq(surroundings, seed=7)


@pytest.fixture
def channel(server: SimulatedDaq) -> InProcessChannel:
    return InProcessChannel(server)


@pytest.fixture
def wiring() -> Wiring:
    return Wiring(
        output="cDAQ1Mod2/ao0",
        drive_input="cDAQ1Mod1/ai0",
        responses=("cDAQ1Mod1/ai1", "cDAQ1Mod1/ai2"),
        thermocouples=("cDAQ1Mod3/ai0",),
        sample_rate=8500.0,
    )


@pytest.fixture
def cards(wiring: Wiring, channel: InProcessChannel) -> DaqmxCards:
    return DaqmxCards(wiring, channel)


@pytest.fixture
def drive() -> Real:
    """Return a linear sweep of one second and a silent half, at 8533.33 Hz."""
    rate = 51_200.0 / 6.0
    time = np.arange(int(rate)) / rate
    tone = 2.0 * np.sin(2.0 * np.pi * (100.0 * time + 700.0 * time**2))
    fade = np.minimum(1.0, np.minimum(time, time[::-1]) / 0.05)
    return np.concatenate([tone * fade, np.zeros(int(rate / 2))])
