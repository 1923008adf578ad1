"""The oven itself, without a language: heat, sensor, regulator and ramp, on a clock that is handed in.

Heat in an oven with a plate in it: two lumps, solved exactly between changes of power.

    C_a dT_a/dt = P - G_w (T_a - T_room) - G_p (T_a - T_p)
    C_p dT_p/dt = G_p (T_a - T_p)

with a the air and what moves with it (shelves, inner walls), p the plate, P the power brought in
(negative: taken out). A plate a few millimetres thick is a lump: its Biot number h d / k in moving air
is of the order 1e-3 for aluminium.
"""

import math
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivers.clock import Clock


@dataclass(frozen=True)
class Chamber:
    """What the heat meets, in SI units but for the room's degrees Celsius.

    Attributes
    ----------
    air_capacity : float
        Heat capacity of air, shelves and inner walls, J/K.
    plate_capacity : float
        Heat capacity of the plate, J/K.
    wall_conductance : float
        From the air through the walls to the room, W/K.
    plate_conductance : float
        From the air to the plate, W/K.
    heating, cooling : float
        Largest power brought in and taken out, W.
    room : float
        degrees Celsius.
    """

    air_capacity: float = 2.0e4
    plate_capacity: float = 900.0
    wall_conductance: float = 15.0
    plate_conductance: float = 6.0
    heating: float = 3000.0
    cooling: float = 2000.0
    room: float = 22.0

    def __post_init__(self) -> None:
        for name in ("air_capacity", "plate_capacity", "wall_conductance", "plate_conductance"):
            value = getattr(self, name)
            if not 0.0 < value < math.inf:
                raise ValueError(f"{name} {value!r} must be above 0 and finite")
        if not (0.0 <= self.heating < math.inf and 0.0 <= self.cooling < math.inf):
            raise ValueError(
                f"heating {self.heating!r} W and cooling {self.cooling!r} W must be 0 or more and finite"
            )
        if not -80.0 <= self.room <= 200.0:
            raise ValueError(f"room {self.room!r} °C; allowed -80 to 200")

    def rates(self) -> NDArray[np.float64]:
        """Return the (2, 2) matrix of d(T - T_room)/dt, air first, 1/s."""
        a, p = self.air_capacity, self.plate_capacity
        return np.array(
            [
                [-(self.wall_conductance + self.plate_conductance) / a, self.plate_conductance / a],
                [self.plate_conductance / p, -self.plate_conductance / p],
            ]
        )


class Heat:
    """Temperatures of air and plate, moved on in steps of one length under constant power.

    Parameters
    ----------
    chamber : Chamber
    step : float
        Seconds.
    air, plate : float, optional
        Start, degrees Celsius; the room's by default.

    Attributes
    ----------
    air, plate : float
        degrees Celsius, now.
    """

    def __init__(
        self, chamber: Chamber, step: float, air: float | None = None, plate: float | None = None
    ) -> None:
        from scipy.linalg import expm

        if not 0.0 < step < math.inf:
            raise ValueError(f"step {step!r} s must be above 0 and finite")
        self.chamber = chamber
        self.step = step
        self.air = chamber.room if air is None else air
        self.plate = chamber.room if plate is None else plate
        rates = chamber.rates()
        # Columns: air, plate and power. Exact for constant power, so the step only says how often the
        # power may change. Kept as floats: two multiply-adds cost less than a call into numpy.
        whole = np.zeros((3, 3))
        whole[:2, :2] = rates
        whole[0, 2] = 1.0 / chamber.air_capacity
        moved = expm(whole * step)
        (self._aa, self._ap, self._ah), (self._pa, self._pp, self._ph) = moved[:2].tolist()

    def advance(self, power: float) -> None:
        """Move on by one step under `power` (W; negative takes heat out), kept within the chamber's means."""
        power = min(max(power, -self.chamber.cooling), self.chamber.heating)
        room = self.chamber.room
        air, plate = self.air - room, self.plate - room
        self.air = room + self._aa * air + self._ap * plate + self._ah * power
        self.plate = room + self._pa * air + self._pp * plate + self._ph * power

    @property
    def stored(self) -> float:
        """Heat held above that at the room's temperature, J."""
        c = self.chamber
        return c.air_capacity * (self.air - c.room) + c.plate_capacity * (self.plate - c.room)


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
