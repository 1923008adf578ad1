"""Supervision of the oven in a thread of its own, which no file, network share or computation can block."""

import logging
import math
import threading
from collections.abc import Callable
from typing import TypeVar

from analysis.protocol.limits import Limits
from drivers.clock import Clock, Stop
from drivers.ovens.error import Fault, OvenError
from drivers.ovens.expiry import Expiring
from drivers.ovens.line import PASSING
from drivers.ovens.oven import Bounded, Oven, OvenLimits, SetPoint
from drivers.rig.errors import RESUME, RigStopped

Result = TypeVar("Result")

PERIOD = 1.0
"""Interval of the supervision's checks, s."""
QUIET = 6.0
"""If the oven was not read for this time, the supervision reads it, s."""
SLOW = 60.0
"""Shortest time allowed to the main thread for checks, files and figures of a long sweep, s."""
HANGS = 20.0
"""A request that occupies the line for longer counts as hung, s."""

LOOK = "Look at the oven, its set-point and its sensors before going on"

log = logging.getLogger(__name__)


class SupervisedOven:
    """An oven that is polled and, after a fault, brought to rest, independently of the main thread.

    It is brought to rest if its air temperature is beyond the limits or it is in alarm; if it has not answered, or
    the main thread has not called, for longer than `limits.lost_after`, because a thread blocked by a file must
    not leave the oven heating; and if the session is to end. From then on every command but `safe` raises the
    reason.

    Commands that expire are renewed only here: if this process dies, such an oven comes to rest.

    The drive needs no thread: it is at 0 V except during a sweep, which calls `check` twice a second.

    Parameters
    ----------
    oven : Oven
        To be used only through this object.
    limits : Limits
    clock : Clock
        Also runs the supervision.
    asked_to_end : callable
        Raises if the session is to end.
    """

    def __init__(self, oven: Oven, limits: Limits, clock: Clock, asked_to_end: Callable[[], None]) -> None:
        self._oven = oven
        self._expiring = oven if isinstance(oven, Expiring) else None
        self._limits = limits
        self._clock = clock
        self._asked_to_end = asked_to_end
        self._quiet = min(QUIET, 0.3 * oven.poll_within)
        self._turn = threading.Lock()
        self._asked = self._answered = self._user = clock.now()
        self._wrong: RigStopped | None = None
        self._at_rest = False
        self._stop: Stop = lambda: None

    @property
    def limits(self) -> OvenLimits:
        """Limits to which set-points are clamped."""
        return self._oven.limits

    @property
    def poll_within(self) -> float:
        """Longest time between two polls of the oven, s; the supervision keeps to it."""
        return self._oven.poll_within

    def begin(self) -> None:
        """Start the supervision."""
        self._user = self._asked = self._answered = self._clock.now()
        self._stop = self._clock.every(PERIOD, self._look)

    def end(self) -> None:
        """End the supervision; the oven is left as it is."""
        self._stop()

    def check(self) -> None:
        """Record that the main thread is alive; raise if the session is to end or the supervision ended it."""
        self._user = self._clock.now()
        self._asked_to_end()
        if self._wrong is not None:
            raise self._wrong

    def temperature(self) -> float:
        """Air temperature, degrees Celsius."""
        return self._called(self._ask)

    def bounds(self) -> tuple[float, float]:
        """Lowest and highest set-point that the controller itself takes, °C; infinite if unknown."""
        return self._called(self._oven.bounds) if isinstance(self._oven, Bounded) else (-math.inf, math.inf)

    def ramp_to(self, target: float, rate: float) -> SetPoint:
        """Start a ramp and return it as accepted."""
        return self._called(lambda: self._oven.ramp_to(target, rate))

    def hold(self) -> float:
        """Stop the ramp and hold the present temperature, which is returned."""
        return self._called(self._oven.hold)

    def renew(self) -> None:
        """Renew the last command if it expires; called by a simulated rig that restores its state."""
        if self._expiring is not None:
            self._called(self._expiring.renew)

    def safe(self) -> None:
        """Bring the oven to rest; OvenError if a hung request blocks the line."""
        if not self._turn.acquire(timeout=HANGS):
            raise OvenError(
                Fault.BUSY, "its line is blocked by an earlier request", "Pull the cable, and plug it in again."
            )
        try:
            self._oven.safe()
        finally:
            self._turn.release()

    def close(self) -> None:
        """Close the port."""
        self._oven.close()

    def _called(self, command: Callable[[], Result]) -> Result:
        self.check()
        with self._turn:
            return command()

    def _ask(self) -> float:
        self._asked = self._clock.now()
        air = self._oven.temperature()
        if math.isfinite(air):
            self._answered = self._clock.now()
        return air

    def _look(self) -> None:
        """Check for faults; after one bring the oven to rest and end the session."""
        if not self._turn.acquire(blocking=False):
            return  # another thread is using it right now
        try:
            self._wrong = self._wrong or self._trouble()
            if self._wrong is not None and not self._at_rest:
                self._oven.safe()
                self._at_rest = True
            if self._wrong is None and self._expiring is not None:
                self._renew(self._expiring)
        except Exception as error:  # noqa: BLE001 (tried again at the next check, and on exit)
            log.warning("the supervision could not bring the oven to rest: %s", error)
        finally:
            self._turn.release()

    def _renew(self, oven: Expiring) -> None:
        try:
            oven.renew()
        except OvenError as error:  # tried again at the next look
            log.warning("the oven's last command could not be renewed, and will expire: %s", error)

    def _trouble(self) -> RigStopped | None:
        now, patience = self._clock.now(), self._limits.lost_after
        try:
            self._asked_to_end()
        except KeyboardInterrupt as request:
            return RigStopped(f"asked to end: {request}", RESUME)
        if now - self._user > max(patience, SLOW):
            what = f"the campaign has stood still for {now - self._user:.0f} s (limits.lost_after {patience:g} s)"
            return RigStopped(what, f"Is its folder out of reach, a network share? {RESUME}")
        if now - self._asked >= self._quiet:
            try:
                return self._beyond(self._ask()) and self._beyond(self._ask())  # one glitch is ignored
            except OvenError as error:
                if error.fault not in PASSING:
                    return RigStopped(str(error), LOOK)
        if now - self._answered > patience:
            return RigStopped(f"no temperature from the oven for {now - self._answered:.0f} s", LOOK)
        return None

    def _beyond(self, air: float) -> RigStopped | None:
        coldest, hottest = self._limits.coldest, self._limits.hottest
        if not math.isfinite(air) or coldest <= air <= hottest:
            return None
        limits = f"limits.coldest and hottest, {coldest:g} to {hottest:g} °C"
        return RigStopped(f"air temperature {air:.1f} °C is outside {limits}", LOOK)
