"""Whether an oven that was switched off is seen to cool: a relay that is welded on reads back as off, too."""

from collections import deque
from dataclasses import dataclass

from drivers.watchdog.guard import Event


@dataclass(frozen=True)
class RestRule:
    """When an oven counts as at rest.

    Attributes
    ----------
    room : float
        Temperature to which an oven goes that neither heats nor cools, degrees Celsius.
    near : float
        Distance within which the air need only be steady, K. The declared temperature of a room, and the sensor of
        an oven, are seldom known better.
    moved : float
        Distance by which the air has to come nearer within `window`, K: three times the resolution of a controller
        that shows tenths.
    window : float
        s. Even a well insulated chamber (time constant 2 h, 30 K above the room) moves by 0.3 K in it.
    steady : float
        Change allowed near the room within `window`, K. A heater of less than 0.4 K/min is not told from walls
        that are warmer than the air.
    away : float
        Distance by which the air may move away, K: after cooling, warmer walls heat the air by a few kelvin; a
        heater that is welded on does this within one or two minutes.
    patience : float
        Time after which an oven that has not been seen to cool counts as not at rest, s.
    unread : float
        The same for an oven whose temperature cannot be read, s.
    """

    room: float
    near: float = 6.0
    moved: float = 0.3
    window: float = 75.0
    steady: float = 0.5
    away: float = 5.0
    patience: float = 600.0
    unread: float = 30.0


class RestWatch:
    """Judges the readings of an oven since it was switched off.

    Parameters
    ----------
    rule : RestRule
    now : float
        Time at which it was switched off, s.
    """

    def __init__(self, rule: RestRule, now: float) -> None:
        self._rule = rule
        self._since = self._read = now
        self._first: float | None = None
        self._nearest = float("inf")
        self._recent: deque[tuple[float, float]] = deque()

    def see(self, now: float, air: float | None) -> Event | None:
        """Judge one more reading.

        Parameters
        ----------
        now : float
            s.
        air : float or None
            Degrees Celsius; None if it could not be read.

        Returns
        -------
        Event or None
            `TOWARDS_ROOM`, `AWAY`, `OVERDUE`; None while nothing can be said.
        """
        rule = self._rule
        if air is None:
            return Event.OVERDUE if now - self._read >= rule.unread else None
        self._read = now
        self._first = air if self._first is None else self._first
        distance = abs(air - rule.room)
        self._nearest = min(self._nearest, distance)
        self._recent.append((now, distance))
        while len(self._recent) > 1 and now - self._recent[0][0] > rule.window:
            self._recent.popleft()
        if distance > self._nearest + rule.away:
            return Event.AWAY
        farthest, nearest = max(seen for _, seen in self._recent), min(seen for _, seen in self._recent)
        long_enough = now - self._recent[0][0] >= 0.9 * rule.window
        if long_enough and distance <= rule.near and farthest - nearest <= rule.steady:
            return Event.TOWARDS_ROOM
        if farthest - distance >= rule.moved and distance <= self._nearest + 0.5 * rule.moved:
            return Event.TOWARDS_ROOM
        return Event.OVERDUE if now - self._since >= rule.patience else None

    def words(self, now: float, air: float | None) -> str:
        """Return what was seen, for a message."""
        seconds = f"{now - self._since:.0f} s"
        if self._first is None or air is None:
            return f"its temperature cannot be read, {seconds} after it was switched off"
        return (
            f"its air went from {self._first:.1f} to {air:.1f} °C in the {seconds} after it was switched off "
            f"(room {self._rule.room:g} °C)"
        )
