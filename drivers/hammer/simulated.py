"""Whoever holds the hammer, simulated: hits when asked, sometimes twice, sometimes too hard.

The cards that record it are the simulated ones of `drivers.ni.simulated`, behind the real driver. What is drawn
for a hit depends on the seed and on its number alone, so that a campaign that is taken up again goes on with the
same hits.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from analysis.checked_fields import check_range
from drivers.clock import Clock
from drivers.ni.modules import NI_9260, OutputModule
from drivers.ni.simulated.surroundings import Module, Surroundings, Temperature
from drivers.ni.wiring import InputWiring

LEAD_TIME = 0.3
"""s before a hit from which its response is computed: one of limited band begins a little before its hit."""
BOUNCE_TIME = (0.012, 0.080)
"""s between the two peaks of a double hit: a hammer that is held too long bounces within a few hundredths."""
SECOND_PEAK_SHARE = (0.2, 0.8)
"""Share of the second peak of the first."""
TOO_HARD = (1.3, 2.0)
"""Force of an overload over what the force channel can hold."""
WIDTH_SPREAD = 0.1
"""Of the width of pulses, relative: a harder hit on the same tip is a little shorter."""

Drawn = Literal["good", "double hit", "overload"]


class PlateUnderHammer(Protocol):
    """Response of the plate to a force at one of its points."""

    def __call__(
        self, point: int, force: NDArray[np.float64], sample_rate: float, temperature: float
    ) -> NDArray[np.float64]:
        """Return the sensors' voltages (K, M).

        Parameters
        ----------
        point : int
            That is hit, from 0.
        force : (M,) ndarray, N
        sample_rate : float, Hz
        temperature : float
            Of the plate, degrees Celsius.
        """
        ...


@dataclass(frozen=True)
class HandSettings:
    """How the simulated hammer is held.

    Attributes
    ----------
    peak : float
        Median force of good hits, N.
    spread : float
        Standard deviation of its logarithm.
    width : float
        Half width of a pulse at 1/e of its height, s.
    double_hits, overloads : float
        Shares of all hits.
    pause : float
        Between being asked and hitting, s; up to twice as long.
    ring : float
        How long the plate is followed after a hit, s.
    """

    peak: float
    spread: float
    width: float
    double_hits: float
    overloads: float
    pause: float
    ring: float

    def __post_init__(self) -> None:
        for name in ("peak", "width", "pause", "ring"):
            check_range(self, 0.0, 1e6, name, above=True)
        check_range(self, 0.0, 1.0, "spread", "double_hits", "overloads")
        if self.double_hits + self.overloads > 1.0:
            raise ValueError(
                f"double_hits {self.double_hits:g} and overloads {self.overloads:g}; together at most 1"
            )


@dataclass(frozen=True)
class Strike:
    """One hit as drawn.

    Attributes
    ----------
    number : int
        In the campaign, from 0.
    point : int
        From 0.
    time : float
        Of its peak on the rig's clock, s.
    drawn : str
    peaks : tuple of (float, float)
        Delay, s, and height, N, of its one or two peaks.
    width : float
        Half width at 1/e, s.
    """

    number: int
    point: int
    time: float
    drawn: Drawn
    peaks: tuple[tuple[float, float], ...]
    width: float

    def force(self, moments: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the force (M,), N, at moments (M,), s."""
        made = np.zeros_like(moments)
        for delay, height in self.peaks:
            made += height * np.exp(-(((moments - self.time - delay) / self.width) ** 2))
        return made


@dataclass
class SimulatedHammer:
    """The hammer, the hand and the plate, as the cards see them (`drivers.ni.simulated.surroundings.StruckPlate`).

    Attributes
    ----------
    plate : PlateUnderHammer
    hand : HandSettings
    clock : Clock
    temperature : callable
        Returns that of the plate now, degrees Celsius.
    force_volts : float
        Sensitivity of the force sensor, V/N.
    full_scale : float
        Of its input, V.
    seed : int
    strikes : list of Strike
        As drawn: what a test of the rejection is held against.
    version : int
    """

    plate: PlateUnderHammer
    hand: HandSettings
    clock: Clock
    temperature: Callable[[], float]
    force_volts: float
    full_scale: float
    seed: int
    strikes: list[Strike] = field(default_factory=list)
    version: int = 0
    _answers: dict[tuple[int, float], NDArray[np.float64]] = field(default_factory=dict, repr=False)

    def ask(self, point: int, number: int) -> None:
        """Have the plate hit at a point, after a pause; a hit that is on its way already is moved there.

        Parameters
        ----------
        point : int
            From 0.
        number : int
            Of the hit in the campaign, from 0.
        """
        rng = np.random.default_rng([self.seed, number, 1])
        luck, pause, wide, bounce, second, hard = rng.uniform(size=6)
        spread = float(rng.standard_normal())
        drawn: Drawn = "good"
        if luck < self.hand.double_hits:
            drawn = "double hit"
        elif luck < self.hand.double_hits + self.hand.overloads:
            drawn = "overload"
        peak = self.hand.peak * float(np.exp(self.hand.spread * spread))
        if drawn == "overload":
            peak = self.full_scale / self.force_volts * (TOO_HARD[0] + (TOO_HARD[1] - TOO_HARD[0]) * hard)
        peaks = [(0.0, peak)]
        if drawn == "double hit":
            share = SECOND_PEAK_SHARE[0] + (SECOND_PEAK_SHARE[1] - SECOND_PEAK_SHARE[0]) * second
            peaks.append((BOUNCE_TIME[0] + (BOUNCE_TIME[1] - BOUNCE_TIME[0]) * bounce, share * peak))
        width = self.hand.width * (1.0 + WIDTH_SPREAD * (2.0 * wide - 1.0))
        now = self.clock.now()
        self.strikes = [one for one in self.strikes if one.time < now]
        time = now + self.hand.pause * (1.0 + pause)
        self.strikes.append(Strike(number, point, time, drawn, tuple(peaks), width))
        self.version += 1

    def __call__(
        self, moments: NDArray[np.float64], sample_rate: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the force sensor's voltage (M,) and those of the plate's sensors (K, M), V.

        Parameters
        ----------
        moments : (M,) ndarray, s
        sample_rate : float
            Hz.
        """
        force = np.zeros(moments.size)
        answer: NDArray[np.float64] | None = None
        for strike in self.strikes:
            began = int(np.ceil((strike.time - LEAD_TIME - moments[0]) * sample_rate))
            length = round((LEAD_TIME + self.hand.ring) * sample_rate)
            first, last = max(began, 0), min(began + length, moments.size)
            if first >= last:
                continue
            grid = moments[0] + np.arange(began, began + length) / sample_rate
            pulse = strike.force(grid)
            heard = self._answer(strike, pulse, grid[0], sample_rate)
            answer = np.zeros((len(heard), moments.size)) if answer is None else answer
            force[first:last] += pulse[first - began : last - began]
            answer[:, first:last] += heard[:, first - began : last - began]
        if answer is None:
            silent = self.plate(0, np.zeros(16), sample_rate, self.temperature())
            answer = np.zeros((len(silent), moments.size))
        return self.force_volts * force, answer

    def _answer(
        self, strike: Strike, pulse: NDArray[np.float64], start: float, sample_rate: float
    ) -> NDArray[np.float64]:
        """Return the response to one hit, computed once on every grid of samples."""
        key = (strike.number, round(start, 7))
        if key not in self._answers:
            while len(self._answers) > 4:  # a hit, the one before that still rings, on two grids at most
                del self._answers[next(iter(self._answers))]
            self._answers[key] = self.plate(strike.point, pulse, sample_rate, self.temperature())
        return self._answers[key]


COUPLING_MEMORY = 6.0
"""s for which the coupling of the inputs is followed: of a corner of 0.5 Hz 1e-8 is left."""


def struck_surroundings(
    cards: InputWiring, hammer: SimulatedHammer, modules: Mapping[int, Module], plate_temperature: Temperature
) -> Surroundings:
    """Wire the hammer and the plate's sensors to simulated cards.

    Parameters
    ----------
    modules : mapping of int to Module
        Slot -> module in it.

    Raises
    ------
    ValueError
        If a terminal is on no module.
    """
    slots = dict(modules)
    output = next((slot for slot, module in slots.items() if isinstance(module, OutputModule)), None)
    if output is None:  # the simulated chassis is made around one; nothing is wired to it here
        output = next(slot for slot in range(1, 9) if slot not in slots)
        slots[output] = NI_9260
    chassis = cards.drive_input.split("/")[0].partition("Mod")[0]
    return Surroundings(
        plate=_unplayed,
        sensors={terminal: row for row, terminal in enumerate(cards.responses)},
        drive_inputs=frozenset({cards.drive_input}),
        output=f"{chassis}Mod{output}/ao0",
        plate_temperature=plate_temperature,
        chassis=chassis,
        modules=slots,
        iepe_sensors=frozenset(cards.iepe),
        memory=COUPLING_MEMORY,
        hammer=hammer,
    )


def _unplayed(
    drive: NDArray[np.float64], sample_rate: float, temperature: NDArray[np.float64]
) -> NDArray[np.float64]:
    raise AssertionError("nothing is played in a hammer test")
