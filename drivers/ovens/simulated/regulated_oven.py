"""The oven itself, without a language: heat, sensor, regulator and ramp, on a clock that is handed in."""

import math
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from drivers.clock import Clock
from drivers.ovens.simulated.thermal import Chamber, Heat


@dataclass(frozen=True)
class Regulator:
    """A proportional-integral regulator: the integral makes it overshoot at the end of a ramp.

    Attributes
    ----------
    gain : float
        W/K.
    integral_time : float
        s.
    period : float
        Between two decisions, s.
    noise : float
        Standard deviation of the sensor's reading, K.
    """

    gain: float = 400.0
    integral_time: float = 100.0
    period: float = 1.0
    noise: float = 0.02


class RegulatedOven:
    """An oven that follows a ramping set-point as well as its power allows.

    Time passes by looking: every property first brings the oven up to the clock.

    Parameters
    ----------
    clock : Clock
    rng : numpy.random.Generator
        For the sensor's noise.
    chamber : Chamber
    regulator : Regulator
    air, plate : float, optional
        Start, degrees Celsius; the room's by default.

    Attributes
    ----------
    stop_at : float
        Clock time at which the oven stops regulating by itself; infinity for never.
    """

    def __init__(
        self,
        clock: Clock,
        rng: np.random.Generator,
        chamber: Chamber | None = None,
        regulator: Regulator | None = None,
        air: float | None = None,
        plate: float | None = None,
    ) -> None:
        self._clock = clock
        self._rng = rng
        self._regulator = regulator or Regulator()
        self._heat = Heat(chamber or Chamber(), self._regulator.period, air, plate)
        self._time = clock.now()
        self._lock = threading.RLock()
        self._measured = self._heat.air
        self._target = self._working = self._heat.air
        self._rate = math.inf
        self._regulating = False
        self._integral = 0.0
        self._power = 0.0
        self.stop_at = math.inf

    @property
    def air(self) -> float:
        """True air temperature, degrees Celsius."""
        with self._caught_up():
            return self._heat.air

    @property
    def plate(self) -> float:
        """True plate temperature, degrees Celsius."""
        with self._caught_up():
            return self._heat.plate

    @property
    def measured(self) -> float:
        """Air temperature as the controller's sensor has it, degrees Celsius."""
        with self._caught_up():
            return self._measured

    @property
    def working(self) -> float:
        """Set-point followed at this moment, degrees Celsius; the temperature measured while it follows none."""
        with self._caught_up():
            return self._working

    @property
    def target(self) -> float:
        """Set-point at the end of the ramp, degrees Celsius."""
        with self._caught_up():
            return self._target

    @property
    def regulating(self) -> bool:
        """Whether the oven follows its set-point."""
        with self._caught_up():
            return self._regulating

    @property
    def output(self) -> float:
        """Share of the power in use, -1 (all the cooling) to 1 (all the heating)."""
        with self._caught_up():
            chamber = self._heat.chamber
            most = chamber.heating if self._power > 0.0 else chamber.cooling
            return self._power / most if most else 0.0

    def go(self, target: float, rate: float, start: float | None = None) -> None:
        """Ramp the working set-point to `target`.

        Parameters
        ----------
        target : float
            Degrees Celsius.
        rate : float
            K/min; infinite: at once.
        start : float, optional
            Where the ramp starts, degrees Celsius; where the working set-point is by default.
        """
        with self._caught_up():
            if start is not None:
                self._working = start
            self._target, self._rate, self._regulating = target, rate, True

    def stop(self) -> None:
        """Neither heat nor cool."""
        with self._caught_up():
            self._rest()

    def run(self, target: float, rate: float, dwell: float, start: float | None = None) -> None:
        """Ramp to `target`, stay there, then stop regulating.

        Parameters
        ----------
        target : float
            Degrees Celsius.
        rate : float
            K/min; infinite: at once.
        dwell : float
            s.
        start : float, optional
            Degrees Celsius; the temperature measured by default.
        """
        with self._caught_up():
            start = self._measured if start is None else start
            ramp = 60.0 * abs(target - start) / rate if rate else 0.0
            self.stop_at = self._time + ramp + dwell
            self.go(target, rate, start)

    def _rest(self) -> None:
        self._regulating, self._power, self._integral = False, 0.0, 0.0

    @contextmanager
    def _caught_up(self) -> Iterator[None]:
        with self._lock:
            now = self._clock.now()
            while self._time + self._heat.step <= now:
                self._decide()
                self._heat.advance(self._power)
                self._time += self._heat.step
            if now >= self.stop_at:
                self._rest()
            yield

    def _decide(self) -> None:
        regulator, chamber = self._regulator, self._heat.chamber
        self._measured = self._heat.air + regulator.noise * float(self._rng.standard_normal())
        if self._time >= self.stop_at:
            self._rest()
        if not self._regulating:
            self._working = self._measured
            return
        step = self._rate * regulator.period / 60.0
        self._working += min(max(self._target - self._working, -step), step)
        error = self._working - self._measured
        integral = self._integral + error * regulator.period / regulator.integral_time
        wanted = regulator.gain * (error + integral)
        self._power = min(max(wanted, -chamber.cooling), chamber.heating)
        # The integral waits while the power is at its end and the error would drive it further.
        if self._power == wanted or (wanted - self._power) * error < 0.0:
            self._integral = integral
