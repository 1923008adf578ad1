"""Supervision of the oven beside the campaign, which no file, network share or computation can block."""

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
from drivers.ovens.oven import Bounded, Contested, Oven, OvenLimits, SetPoint
from drivers.rig.end_requests import RESUME, RigStopped
from drivers.watchdog.guard import Event, Reaction, RestRule, RestWatch, State, after

Result = TypeVar("Result")

PERIOD = 1.0
"""Interval of the supervision's checks, s."""
QUIET = 6.0
"""If the oven was not read for this time, the supervision reads it, s."""
SLOW = 60.0
"""Shortest time allowed to the campaign for checks, files and figures of a long sweep, s."""
HANGS = 20.0
"""A request that occupies the line for longer counts as hung, s."""
OFF_WITHIN = 15.0
"""Time in which switching off has to read back before people are told, s."""
AGAIN = 60.0
"""Interval at which people are told again while the oven is not at rest, s."""
REOPENED_AFTER = 3
"""Failed attempts to switch off after which the port is opened anew: one that was lost and is back needs that."""

COMPARED = 1.0
"""Shortest interval at which a controller is asked whether it holds what it was commanded, s: with every reading
of its temperature, so that the times of readings do not depend on when the campaign was begun."""

WHO = (
    "Its panel, a programme of its own, or another computer. It was switched off; find out who, then run the same "
    "command again"
)
LOOK = "Look at the oven, its set-point and its sensors before going on"
PULL = "Go there and switch it off; if it does not cool then, pull its mains plug"

log = logging.getLogger(__name__)


def untold(message: str) -> None:
    """Tell nobody: the session that ends says it, or time is virtual."""


class SupervisedOven:
    """An oven that is polled and, after a fault, brought to rest, independently of the campaign.

    It is brought to rest if its air temperature is beyond the limits or it is in alarm; if it has not answered for
    longer than `limits.lost_after`, or the campaign has not called for that time, because a thread blocked by a
    file must not leave the oven heating; and if the campaign is to end. From then on every command but `safe` and,
    once that was called, `temperature` raises the reason. What follows from what stands in `guard`.

    Commands that expire are renewed only here: if this process dies, such an oven comes to rest.

    Parameters
    ----------
    oven : Oven
        To be used only through this object.
    limits : Limits
    clock : Clock
        Also runs the supervision.
    asked_to_end : callable
        Raises if the campaign is to end: KeyboardInterrupt, or RigStopped with the reason.
    rule : RestRule, optional
        When the oven counts as at rest; without it, as soon as it reads back as switched off.
    reopen : callable, optional
        Opens the oven anew, for a port that was lost and is back.
    tell : callable
        Receives what people have to be told: NOT AT REST.
    """

    def __init__(
        self,
        oven: Oven,
        limits: Limits,
        clock: Clock,
        asked_to_end: Callable[[], None],
        rule: RestRule | None = None,
        *,
        reopen: Callable[[], Oven] | None = None,
        tell: Callable[[str], None] = untold,
    ) -> None:
        self._oven = oven
        self._limits = limits
        self._clock = clock
        self._asked_to_end = asked_to_end
        self._rule, self._reopen, self._tell = rule, reopen, tell
        self._quiet = min(QUIET, 0.3 * oven.poll_within)
        self._turn = threading.Lock()
        self._asked = self._user = clock.now()
        self._unanswered = math.inf
        self._wrong: RigStopped | None = None
        self._state = State.WATCHING
        self._since, self._told = clock.now(), -math.inf
        self._failed = 0
        self._resting: RestWatch | None = None
        self._own_end = False
        self._compared = -math.inf
        self._stop: Stop = lambda: None

    @property
    def limits(self) -> OvenLimits:
        """Limits to which set-points are clamped."""
        return self._oven.limits

    @property
    def poll_within(self) -> float:
        """Longest time between two polls of the oven, s; the supervision keeps to it."""
        return self._oven.poll_within

    @property
    def state(self) -> State:
        """What is known of the oven now."""
        return self._state

    @property
    def wrong(self) -> RigStopped | None:
        """Why the supervision has ended the campaign; None while it has not."""
        return self._wrong

    def begin(self) -> None:
        """Start the supervision."""
        self._user = self._asked = self._clock.now()
        self._unanswered = math.inf
        self._stop = self._clock.every(PERIOD, self._look)

    def end(self) -> None:
        """End the supervision; the oven is left as it is."""
        self._stop()

    def restored(self, restore: Callable[[Oven], None]) -> None:
        """Let a simulated rig set its oven to its last state; hours of its time may pass, without supervision."""
        self.end()
        restore(self._oven)
        self.begin()

    def alive(self, age: float = 0.0) -> None:
        """Record that the campaign was alive `age` s ago."""
        self._user = max(self._user, self._clock.now() - age)

    def check(self) -> None:
        """Record that the campaign is alive; raise if it is to end or the supervision ended it."""
        self.alive()
        self._asked_to_end()
        if self._wrong is not None:
            raise self._wrong

    def temperature(self) -> float:
        """Air temperature, degrees Celsius."""
        if not self._own_end:
            self.check()
        with self._turn:
            return self._ask()

    def bounds(self) -> tuple[float, float]:
        """Lowest and highest set-point that the controller itself takes, °C; infinite if unknown."""
        self.check()
        with self._turn:
            return self._oven.bounds() if isinstance(self._oven, Bounded) else (-math.inf, math.inf)

    def ramp_to(self, target: float, rate: float) -> SetPoint:
        """Start a ramp and return it as accepted."""
        return self._commanded(lambda: self._oven.ramp_to(target, rate))

    def hold(self) -> float:
        """Stop the ramp and hold the present temperature, which is returned."""
        return self._commanded(self._oven.hold)

    def renew(self) -> None:
        """Renew the last command if it expires; called by a simulated rig that restores its state."""
        self.check()
        with self._turn:
            if isinstance(self._oven, Expiring):
                self._oven.renew()

    def safe(self) -> None:
        """Switch the oven off; OvenError if that cannot be verified, or a hung request blocks the line."""
        if not self._turn.acquire(timeout=HANGS):
            raise OvenError(
                Fault.BUSY, "its line is blocked by an earlier request", "Pull the cable, and plug it in again."
            )
        try:
            self._own_end = True
            self._apply(Event.REST_WANTED)
            self._switch_off()
        finally:
            self._turn.release()

    def close(self) -> None:
        """Close the port."""
        self._oven.close()

    def _commanded(self, command: Callable[[], Result]) -> Result:
        self.check()
        with self._turn:
            if self._apply(Event.COMMAND) is not Reaction.OBEY:
                raise self._wrong or RigStopped(f"the oven is {self._state}: it takes no command", RESUME)
            return command()

    def _require_ours(self) -> None:
        """End the campaign where somebody else commands the oven; read twice, for no answer is beyond doubt."""
        if self._state is not State.WATCHING or self._wrong is not None or not isinstance(self._oven, Contested):
            return
        if self._clock.now() - self._compared < COMPARED:
            return
        self._compared = self._clock.now()
        try:
            seen = self._oven.changed() and self._oven.changed()
        except OvenError as error:  # the next reading of the temperature says what is wrong with the line
            log.debug("what the oven was commanded could not be read: %s", error)
            return
        if seen:
            self._wrong = RigStopped(f"somebody else commands the oven: {seen}", WHO)

    def _ask(self) -> float:
        """Read the air temperature; how long the oven has not answered counts from the first question.

        What was commanded is compared before, so that the air is read as close to the plate as without it.
        """
        self._require_ours()
        self._asked = self._clock.now()
        try:
            air = self._oven.temperature()
        except OvenError:
            self._unanswered = min(self._unanswered, self._asked)
            raise
        self._unanswered = math.inf if math.isfinite(air) else min(self._unanswered, self._asked)
        return air

    def _apply(self, event: Event) -> Reaction:
        state, action = after(self._state, event)
        if state is not self._state:
            log.info("the oven: %s, after %s", state, event)
            self._state, self._since = state, self._clock.now()
        return action

    def _switch_off(self) -> None:
        """Switch off once and read back; OvenError and everything else as the driver raises it."""
        try:
            if self._failed >= REOPENED_AFTER and self._reopen is not None:
                self._oven.close()
                self._oven = self._reopen()
            self._oven.safe()
        except BaseException:
            self._failed += 1
            self._apply(Event.OFF_FAILED)
            raise
        self._failed = 0
        self._apply(Event.OFF_TAKEN)
        if self._resting is None and self._rule is not None:
            self._resting = RestWatch(self._rule, self._clock.now())

    def _look(self) -> None:
        """Check for faults; after one bring the oven to rest and end the campaign."""
        if not self._turn.acquire(blocking=False):
            self._look_at_hung_line()
            return
        try:
            if self._state is State.WATCHING:
                self._watch()
            if self._state is not State.WATCHING:
                self._rest()
        except Exception as error:  # noqa: BLE001 (tried again at the next check, and on exit)
            log.info("the supervision could not bring the oven to rest: %s", error)
        finally:
            self._turn.release()

    def _look_at_hung_line(self) -> None:
        """Another thread uses the line: after a fault, tell people if it does so for too long."""
        try:
            self._wrong = self._wrong or self._trouble_of_campaign()
        except Exception as error:  # noqa: BLE001 (the supervision goes on whatever it is)
            log.warning("the supervision: %s", error)
        if self._wrong is not None and self._state is State.WATCHING and self._clock.now() - self._asked > HANGS:
            self._say("its line is blocked by an earlier request")

    def _watch(self) -> None:
        trouble = self._trouble()  # which may find itself that somebody else commands the oven
        self._wrong = self._wrong or trouble
        if self._wrong is not None:
            self._apply(Event.TROUBLE)
        elif isinstance(self._oven, Expiring):
            try:
                self._oven.renew()
            except OvenError as error:  # tried again at the next look
                log.warning("the oven's last command could not be renewed, and will expire: %s", error)

    def _rest(self) -> None:
        """One step on the way to rest: switch off, or watch the oven cool."""
        now = self._clock.now()
        if self._state in (State.RESTING, State.UNREACHED):
            try:
                self._switch_off()
            except Exception as error:
                if now - self._since >= OFF_WITHIN and self._apply(Event.OVERDUE) is Reaction.TELL:
                    self._say(f"it cannot be switched off: {error}")
                raise
            return
        if self._resting is None or self._state is State.AT_REST or now - self._asked < min(2.0, self._quiet):
            return
        try:
            air: float | None = self._ask()
        except OvenError:
            air = None
        event = self._resting.see(now, air)
        action = self._apply(event) if event is not None else Reaction.NOTHING
        if action is Reaction.TELL_REST:
            self._tell(f"the oven cools after all: {self._resting.words(now, air)}")
        if self._state is State.HOT:
            self._say(f"it reads back as switched off, but {self._resting.words(now, air)}")
            if action in (Reaction.TELL, Reaction.SWITCH_OFF):
                self._switch_off()

    def _say(self, what: str) -> None:
        now = self._clock.now()
        if now - self._told >= AGAIN or self._told < self._since:
            self._told = now
            self._tell(f"NOT AT REST: the oven: {what}. {PULL}.")

    def _trouble_of_campaign(self) -> RigStopped | None:
        now, patience = self._clock.now(), self._limits.lost_after
        try:
            self._asked_to_end()
        except KeyboardInterrupt as request:
            return RigStopped(f"asked to end: {request}", RESUME)
        except RigStopped as stopped:
            return stopped
        if now - self._user > max(patience, SLOW):
            what = f"the campaign has stood still for {now - self._user:.0f} s (limits.lost_after {patience:g} s)"
            return RigStopped(what, f"Is its folder out of reach, a network share? {RESUME}")
        return None

    def _trouble(self) -> RigStopped | None:
        trouble = self._trouble_of_campaign()
        if trouble is not None:
            return trouble
        now = self._clock.now()
        if now - self._asked >= self._quiet:
            try:
                return self._beyond(self._ask()) and self._beyond(self._ask())  # one glitch is ignored
            except OvenError as error:
                if error.fault not in PASSING:
                    return RigStopped(str(error), LOOK)
        if now - self._unanswered > self._limits.lost_after:
            return RigStopped(f"no temperature from the oven for {now - self._unanswered:.0f} s", LOOK)
        return None

    def _beyond(self, air: float) -> RigStopped | None:
        coldest, hottest = self._limits.coldest, self._limits.hottest
        if not math.isfinite(air) or coldest <= air <= hottest:
            return None
        limits = f"limits.coldest and hottest, {coldest:g} to {hottest:g} °C"
        return RigStopped(f"air temperature {air:.1f} °C is outside {limits}", LOOK)
