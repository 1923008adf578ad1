"""The state machine of the supervision: pure, so that every event in every state can be tried out.

A state is left only along the table below; what is not in it changes nothing and is not obeyed. Only `WATCHING`
obeys the campaign; no event leads back to it.
"""

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
