"""The state machine of the supervision: pure, so that every event in every state can be tried out.

A state is left only along the table below; what is not in it changes nothing and is not obeyed. Only `WATCHING`
obeys the campaign; no event leads back to it.

Whether an oven that was switched off is seen to cool: a relay that is welded on reads back as off, too.
"""

from collections import deque
from dataclasses import dataclass
from enum import StrEnum


class State(StrEnum):
    """What is known of the oven."""

    WATCHING = "watching"
    """It follows the campaign's commands, its temperature is read, nothing is wrong."""
    RESTING = "resting"
    """It is being switched off; this does not read back yet."""
    COOLING = "cooling"
    """It reads back as switched off, and has not been seen to cool yet."""
    AT_REST = "at rest"
    """It reads back as switched off and goes to the room's temperature, or stays there."""
    UNREACHED = "unreached"
    """NOT AT REST: it cannot be switched off; told to people, and tried again."""
    HOT = "hot"
    """NOT AT REST: it reads back as switched off and does not cool; told to people, and watched further."""


class Event(StrEnum):
    """What may happen."""

    COMMAND = "command"
    """The campaign wants a ramp, or a temperature held."""
    REST_WANTED = "rest wanted"
    """The campaign has ended and wants the oven at rest."""
    TROUBLE = "trouble"
    """Beyond the limits, alarm, no contact, or the campaign is asked to end, silent, stopped, stuck or dead."""
    OFF_TAKEN = "off taken"
    """Switched off, and read back."""
    OFF_FAILED = "off failed"
    """Not switched off, or not read back."""
    OVERDUE = "overdue"
    """What the state waits for has not happened in its time."""
    TOWARDS_ROOM = "towards the room"
    """The air goes to the room's temperature, or is steady near it."""
    AWAY = "away from the room"
    """The air goes away from it."""


class Reaction(StrEnum):
    """What is done at once."""

    NOTHING = "nothing"
    OBEY = "obey"
    REFUSE = "refuse"
    """Raise why."""
    SWITCH_OFF = "switch off"
    TELL = "tell"
    """Switch off once more, and say NOT AT REST."""
    TELL_REST = "tell rest"
    """Say that it is at rest after all."""


S, E, A = State, Event, Reaction

TABLE: dict[tuple[State, Event], tuple[State, Reaction]] = {
    (S.WATCHING, E.COMMAND): (S.WATCHING, A.OBEY),
    (S.WATCHING, E.REST_WANTED): (S.RESTING, A.SWITCH_OFF),
    (S.WATCHING, E.TROUBLE): (S.RESTING, A.SWITCH_OFF),
    (S.RESTING, E.OFF_TAKEN): (S.COOLING, A.NOTHING),
    (S.RESTING, E.OFF_FAILED): (S.RESTING, A.SWITCH_OFF),
    (S.RESTING, E.OVERDUE): (S.UNREACHED, A.TELL),
    (S.COOLING, E.OFF_FAILED): (S.RESTING, A.SWITCH_OFF),
    (S.COOLING, E.TOWARDS_ROOM): (S.AT_REST, A.NOTHING),
    (S.COOLING, E.AWAY): (S.HOT, A.TELL),
    (S.COOLING, E.OVERDUE): (S.HOT, A.TELL),
    (S.AT_REST, E.AWAY): (S.HOT, A.TELL),
    (S.AT_REST, E.OFF_FAILED): (S.RESTING, A.SWITCH_OFF),
    (S.UNREACHED, E.OFF_TAKEN): (S.COOLING, A.NOTHING),
    (S.UNREACHED, E.OFF_FAILED): (S.UNREACHED, A.SWITCH_OFF),
    (S.UNREACHED, E.OVERDUE): (S.UNREACHED, A.TELL),
    (S.HOT, E.TOWARDS_ROOM): (S.AT_REST, A.TELL_REST),
    (S.HOT, E.OFF_FAILED): (S.UNREACHED, A.TELL),
    (S.HOT, E.AWAY): (S.HOT, A.SWITCH_OFF),
    (S.HOT, E.OVERDUE): (S.HOT, A.TELL),
    **{
        (state, E.REST_WANTED): (state, A.SWITCH_OFF)
        for state in (S.RESTING, S.COOLING, S.AT_REST, S.UNREACHED, S.HOT)
    },
}
"""(state, event) -> (state after it, action)."""


def after(state: State, event: Event) -> tuple[State, Reaction]:
    """Return the state that follows, and the action.

    Returns
    -------
    State
    Reaction
        A command that is not obeyed is refused.
    """
    return TABLE.get((state, event), (state, A.REFUSE if event is E.COMMAND else A.NOTHING))


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
