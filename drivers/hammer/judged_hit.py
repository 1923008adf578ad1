"""A hit that was recorded: in SI units, and judged by what judges it when it is read back.

The temperature of the plate then comes with what is in doubt about it, in an oven or in a room.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.estimation.impacts import HammerTest, find_blows
from analysis.estimation.recording import SampledSignals
from analysis.estimation.spectra import Spectra
from analysis.plate_temperature.plate_sensors import APART
from analysis.plate_temperature.sensor_check import OPEN


@dataclass(frozen=True)
class JudgedHit:
    """One hit.

    Attributes
    ----------
    force : (N,) ndarray, N
    responses : (K, N) ndarray, SI
    sample_rate : float
        Hz.
    peak : float
        Largest force, N.
    rejected : str
        Why it does not count; empty where it does.
    spectra : Spectra or None
        Of its block; None where it does not count.
    """

    force: NDArray[np.float64]
    responses: NDArray[np.float64]
    sample_rate: float
    peak: float
    rejected: str
    spectra: Spectra | None


@dataclass(frozen=True)
class HitJudge:
    """Turns volts into units and says whether a hit counts.

    Attributes
    ----------
    test : HammerTest
        With trigger, pretrigger and duration.
    volts : (1 + K,) tuple of float
        Sensitivities, V per unit, force first.
    names : (1 + K,) tuple of str
        Of the channels, for messages.
    largest : float
        Voltage from which a channel counts as overloaded, V.
    """

    test: HammerTest
    volts: tuple[float, ...]
    names: tuple[str, ...]
    largest: float

    def __post_init__(self) -> None:
        if len(self.names) != len(self.volts) or not all(volts > 0.0 for volts in self.volts):
            raise ValueError(f"sensitivities {self.volts} of channels {self.names}; one each, above 0")
        if not self.largest > 0.0:
            raise ValueError(f"largest voltage {self.largest:g} V; above 0 allowed")
        if self.test.trigger is None or self.test.pretrigger is None or self.test.duration is None:
            raise ValueError("trigger, pretrigger and duration of a hammer test that is recorded must be given")

    def judge(self, record: NDArray[np.float64], sample_rate: float) -> JudgedHit:
        """Judge a hit.

        Parameters
        ----------
        record : (1 + K, N) ndarray, V
            As `HitTrigger.feed` gives it.
        sample_rate : float
            Hz.
        """
        # single precision is what is written: it is judged as it will be read
        measured = (record / np.array(self.volts)[:, None]).astype(np.float32).astype(float)
        return self.judge_measured(measured[0], measured[1:], sample_rate)

    def judge_measured(
        self, force: NDArray[np.float64], responses: NDArray[np.float64], sample_rate: float
    ) -> JudgedHit:
        """Judge a hit in SI units.

        Parameters
        ----------
        force : (N,) ndarray, N
        responses : (K, N) ndarray, SI
        sample_rate : float
            Hz.
        """
        signals = SampledSignals(sample_rate, force[None], responses)
        try:
            blows = find_blows(signals, self.test, self.full_scales, self.names)
        except ValueError as error:  # the force that triggered it is gone once the offset is taken out
            return JudgedHit(force, responses, sample_rate, float(force.max()), f"no hit: {error}", None)
        hit, *others = blows.hits
        rejected = hit.rejected
        pushed, pulled = float(force.max() - np.median(force)), float(np.median(force) - force.min())
        if pulled > pushed:
            rejected = "the force is negative; exchange the poles of its sensor, or turn the hammer's tip round"
        if not rejected and others:
            rejected = f"double hit: another hit {1e3 * (others[0].start - hit.start) / sample_rate:.1f} ms later"
        return JudgedHit(force, responses, sample_rate, hit.peak, rejected, None if rejected else blows.spectra())

    @property
    def full_scales(self) -> Sequence[float]:
        """Value from which each channel counts as overloaded, in its unit, force first."""
        return [self.largest / volts for volts in self.volts]


@dataclass(frozen=True)
class HitTemperature:
    """Temperature at one moment.

    Attributes
    ----------
    value : float
        Degrees Celsius; NaN where there is no usable reading.
    doubt : str
        Why it may be wrong; empty where nothing says so.
    """

    value: float
    doubt: str = ""


def declared(value: float) -> Callable[[], HitTemperature]:
    """Return what gives a temperature that was written into the experiment."""
    return lambda: HitTemperature(value)


def in_a_room(read: Callable[[], Real], names: Sequence[str]) -> Callable[[], HitTemperature]:
    """Return what gives the mean of the thermocouples on a plate that no oven heats.

    Without an oven no air is measured by which a single reading could be judged: sensors that are open or shorted
    are left out, and several are compared with one another.

    Parameters
    ----------
    read : callable
        Returns a reading of each sensor (C,), degrees Celsius.
    names : (C,) sequence of str
        Of the sensors, for messages.
    """

    def temperature() -> HitTemperature:
        readings = dict(zip(names, map(float, read()), strict=True))
        usable = {name: value for name, value in readings.items() if OPEN[0] < value < OPEN[1]}
        doubts = [
            f"{name} reads {readings[name]:g} °C: open or shorted" for name in readings if name not in usable
        ]
        doubts += [
            f"{one} and {other} read {abs(usable[one] - usable[other]):.1f} K apart"
            for one, other in combinations(usable, 2)
            if abs(usable[one] - usable[other]) > APART
        ]
        mean = sum(usable.values()) / len(usable) if usable else math.nan
        return HitTemperature(mean, "; ".join(doubts))

    return temperature
