"""An oven of which only its points are known: where to read a temperature, set a set-point, switch on and off."""

import logging
import math
from collections.abc import Callable
from functools import partial

from drivers.clock import Clock, Stop
from drivers.ovens.error import Fault, OvenError
from drivers.ovens.line import PASSING, Line
from drivers.ovens.oven import OvenLimits, SetPoint, other_set_point
from drivers.ovens.points import PLAUSIBLE, Points

PERIOD = 1.0
"""Between two looks at whether a ramp in steps is due for its next, s."""

LAG = 5.0
"""The air may be so far from the set-point of an oven that follows its ramp, K."""

COARSEST = 1.0
"""A set-point in coarser steps is of no use here, K."""

log = logging.getLogger(__name__)


class MappedOven:
    """Ramps by the controller where that has a rate, in steps of the set-point where it has none.

    The steps are made by a thread of this program: where that dies, the oven stays at the last of them. Safe
    state: switched off, or, of a controller that cannot be, the set-point `Points.rest_at`.

    Parameters
    ----------
    line : Line
        The points are on it.
    points : Points
    limits : OvenLimits
    clock : Clock
        Carries the steps.
    step : float
        Of a ramp in steps, K: many controllers keep their set-point in a memory that wears out.
    """

    poll_within = math.inf

    def __init__(self, line: Line, points: Points, limits: OvenLimits, clock: Clock, step: float) -> None:
        self.limits = limits
        self._line = line
        self._points = points
        self._clock = clock
        self._step = step
        self._usable = self._commanded = False
        self._ramp: tuple[float, float, float, float] | None = None
        self._failed: OvenError | None = None
        self._told: float | None = None
        self._stop_stepping: Stop = lambda: None

    def temperature(self) -> float:
        """Air temperature, degrees Celsius; OvenError for an alarm, or for a fault of the last step.

        The first time, of kind refused where it is none, or another point cannot be read.
        """
        points = self._points
        with self._line.reserved():
            if self._failed is not None:
                raise self._failed
            points.require_good()
            value = points.temperature.read()
            if self._commanded and points.run is not None and not (points.run.on() or points.run.on()):
                raise OvenError(
                    Fault.ALARM,
                    f"the oven has stopped by itself at {value:g} °C",
                    "Was it stopped on its panel, or by its limiter? Look at it, then start the ramp again.",
                )
        if not math.isfinite(value):
            raise OvenError(
                Fault.ALARM,
                f"the controller has no valid temperature ({value})",
                "Check the sensor and its wiring.",
            )
        if not self._usable:
            self._require_declared(value)
            self._usable = True
        return value

    def ramp_to(self, target: float, rate: float) -> SetPoint:
        """Let the controller ramp, or begin to step.

        Raises
        ------
        ValueError
            For a rate that is less than the controller's smallest.
        """
        wanted = self.limits.clamp(target, rate)
        self._require_usable()
        points = self._points
        with self._line.reserved():
            self._end_steps()
            if points.rate is None:
                return self._begin_steps(wanted)
            if wanted.rate < points.rate.resolution:
                raise ValueError(
                    f"rate {rate:g} K/min: this controller's rate has steps of {points.rate.resolution:g} K/min"
                )
            taken_rate = points.rate.put(wanted.rate)
            taken = points.set_point.put(wanted.target)
            self._switch_on()
            self._told = taken
        return SetPoint(taken, taken_rate)

    def hold(self) -> float:
        """Make the set-point where the ramp is; the measured temperature if the controller does not report it."""
        self._require_usable()
        points = self._points
        with self._line.reserved():
            stepped = self._working()
            self._end_steps()
            if stepped is not None:
                here = stepped
            elif points.working is not None and self._running():
                here = points.working.read()
            else:
                here = points.temperature.read()
            held = points.set_point.put(self.limits.clamp_target(here))
            self._switch_on()
            self._told = held
            return held

    def changed(self) -> str:
        """Say whether the set-point is another than the one written last."""
        with self._line.reserved():
            return "" if self._told is None else other_set_point(self._told, self._points.set_point.read())

    def safe(self) -> None:
        """Switch off; or go to `rest_at`."""
        points = self._points
        with self._line.reserved():
            self._told = None
            self._end_steps()
            self._commanded = False
            commands: list[Callable[[], None]] = []
            if points.run is not None:
                commands.append(partial(points.run.send, False))
            if points.rest_at is not None:
                commands.append(partial(points.set_point.send, points.rest_at))
            self._line.blind(*commands)
            if points.run is not None:
                points.run.put(False)
            if points.rest_at is not None:
                points.set_point.put(points.rest_at)

    def close(self) -> None:
        """Step no more, and let go of the line."""
        self._end_steps()
        self._line.close()

    def _switch_on(self) -> None:
        if self._points.run is not None:
            self._points.run.put(True)
        self._commanded = True

    def _running(self) -> bool:
        return self._commanded if self._points.run is None else self._points.run.on()

    def _begin_steps(self, wanted: SetPoint) -> SetPoint:
        """Start where the oven is: at its temperature, or, while it regulates, at a set-point near that."""
        points = self._points
        start = air = points.temperature.read()
        if self._running():
            start = min(max(points.set_point.read(), air - LAG), air + LAG)
        start = self.limits.clamp_target(start)
        self._told = points.set_point.put(start)
        self._switch_on()
        self._ramp = (self._clock.now(), start, wanted.target, wanted.rate / 60.0)
        self._written = start
        self._stop_stepping = self._clock.every(PERIOD, self._look)
        return wanted

    def _working(self) -> float | None:
        """Return where a ramp in steps ought to be now, degrees Celsius; None where none is under way."""
        if self._ramp is None:
            return None
        begun, start, target, rate = self._ramp
        moved = rate * (self._clock.now() - begun)
        return min(start + moved, target) if target >= start else max(start - moved, target)

    def _look(self) -> None:
        """Make the next step where it is due; one that the line lost is due again at the next look."""
        try:
            with self._line.reserved():
                due = self._working()
                if due is None or self._ramp is None:
                    return
                end = due == self._ramp[2]
                if abs(due - self._written) >= self._step or end:
                    self._told = self._points.set_point.put(due)
                    self._written = due
                if end:
                    self._end_steps()
        except OvenError as error:
            log.debug("a step of the oven's ramp failed: %s", error)
            if error.fault not in {*PASSING, Fault.LOST}:  # the next temperature reading reports these
                self._end_steps()
                self._failed = error

    def _end_steps(self) -> None:
        self._stop_stepping()
        self._ramp = self._failed = None

    def _require_usable(self) -> None:
        """Before the first command, not on opening: an oven in alarm can be opened and brought to rest."""
        if not self._usable:
            self.temperature()

    def _require_declared(self, value: float) -> None:
        points, (low, high) = self._points, PLAUSIBLE
        with self._line.reserved():
            for point in (points.set_point, points.working, points.rate):
                if point is not None:
                    point.read()
            if points.run is not None:
                points.run.on()
        if not low <= value <= high:
            raise OvenError(
                Fault.REFUSED,
                f"the temperature reads {value:g} °C; {low:g} to {high:g} °C can be true",
                "Correct what the experiment declares of it: place, type, scale, offset, unit, order of words.",
            )


def require_rest(switch: bool, rest_at: float | None, limits: OvenLimits) -> None:
    """Raise unless a declaration says, in one way, how the oven comes to rest.

    Parameters
    ----------
    switch : bool
        Whether a register or command that switches the oven off is declared.
    rest_at : float or None
        Temperature at which the oven is left instead, degrees Celsius.

    Raises
    ------
    ValueError
        If both or neither is declared, or `rest_at` lies outside the limits.
    """
    if switch == (rest_at is not None):
        raise ValueError(
            f"{'both run and rest_at' if switch else 'neither run nor rest_at'} declared to bring it to rest; "
            "declare run (how it is switched off) or, for a controller that cannot be, rest_at (a temperature)"
        )
    if rest_at is not None and not limits.minimum <= rest_at <= limits.maximum:
        raise ValueError(
            f"rest_at {rest_at:g} °C; minimum to maximum allowed, {limits.minimum:g} to {limits.maximum:g}"
        )
