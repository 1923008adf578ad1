"""A hit that was recorded: in SI units, and judged by what judges it when it is read back.

The temperature of the plate then comes with what is in doubt about it, in an oven or in a room.

What of a hammer test is measured, undone and left out: from the hits on the disk and the log beside them.

Files are the truth of what was recorded; the log says what of it does not count any more. A hit is never deleted.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.estimation.impacts import HammerTest, find_blows
from analysis.estimation.spectra import SampledSignals, Spectra
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


ACCEPTED, REJECTED, UNDONE, SKIPPED = "hit", "hit rejected", "hit undone", "point skipped"
"""Events of the log. All have the number of the hit, ``step``, but for the last, which has the point."""
IN_DOUBT = "temperature in doubt"
"""Event of the station; with ``step`` where it is about a hit that was kept."""


@dataclass(frozen=True, order=True)
class KeptHit:
    """A hit on the disk that was accepted when it was made.

    Attributes
    ----------
    number : int
        Of all hits of the campaign, rejected ones too, from 0.
    set_point : int
        Temperature at which it was made, from 0; 0 of a test at one temperature.
    point : int
        That was hit, from 0.
    """

    number: int
    set_point: int
    point: int


@dataclass
class HammerProgress:
    """State of a campaign, changed hit by hit.

    Attributes
    ----------
    points : int
        That are hit at every set-point.
    wanted : int
        Hits at each.
    valid : list of KeptHit
        That count, in the order made.
    skipped : set of (int, int)
        Set-points and points that were left out.
    recorded : int
        Hits so far, rejected and undone ones too: the number of the next one.
    rejected : int
    """

    points: int
    wanted: int
    valid: list[KeptHit] = field(default_factory=list)
    skipped: set[tuple[int, int]] = field(default_factory=set)
    recorded: int = 0
    rejected: int = 0

    @classmethod
    def of(
        cls,
        points: int,
        wanted: int,
        kept: Iterable[KeptHit],
        events: Sequence[Mapping[str, Any]],
        *,
        again: bool = False,
    ) -> "HammerProgress":
        """Return the state of a campaign that may have been interrupted.

        Parameters
        ----------
        kept : iterable of KeptHit
            On the disk.
        events : sequence of mapping
            The log.
        again : bool
            Whether points that were skipped are asked for once more.
        """
        undone = {int(event["step"]) for event in events if event.get("event") == UNDONE}
        rejected = {int(event["step"]) for event in events if event.get("event") == REJECTED}
        there = sorted(kept)
        skipped = {
            (int(event["set_point"]), int(event["point"])) for event in events if event.get("event") == SKIPPED
        }
        return cls(
            points,
            wanted,
            [hit for hit in there if hit.number not in undone],
            set() if again else skipped,
            1 + max([*(hit.number for hit in there), *rejected], default=-1),
            len(rejected),
        )

    def at(self, set_point: int, point: int) -> list[KeptHit]:
        """Return the hits that count at a point."""
        return [hit for hit in self.valid if (hit.set_point, hit.point) == (set_point, point)]

    def next_point(self, set_point: int) -> int | None:
        """Return the first point that lacks hits, from 0; None where all is measured or left out."""
        for point in range(self.points):
            if (set_point, point) not in self.skipped and len(self.at(set_point, point)) < self.wanted:
                return point
        return None

    def doubted(self, events: Iterable[Mapping[str, Any]]) -> set[int]:
        """Return the numbers of the hits that count and whose temperature is in doubt, by the log."""
        told = {
            event.get("step")
            for event in events
            if (event.get("event") == ACCEPTED and event.get("doubt")) or event.get("event") == IN_DOUBT
        }
        return {hit.number for hit in self.valid} & told

    def missing(self, set_point: int) -> int:
        """Return how many hits are still wanted, those of skipped points too."""
        return sum(max(self.wanted - len(self.at(set_point, point)), 0) for point in range(self.points))
