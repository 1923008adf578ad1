"""Every event in every state, and every sequence of them: what must never happen does not."""

from itertools import product

import pytest

from drivers.watchdog.guard import TABLE, Event, Reaction, State, after

TOLD = {State.UNREACHED, State.HOT}
"""States of which people have been told NOT AT REST."""
REST = {State.RESTING, State.COOLING, State.AT_REST, *TOLD}


@pytest.mark.parametrize(("state", "event"), list(product(State, Event)))
def test_every_event_in_every_state(state: State, event: Event) -> None:
    then, action = after(state, event)
    if state is not State.WATCHING:  # no way back to obedience
        assert then is not State.WATCHING
        assert action is not Reaction.OBEY
    if event is Event.COMMAND:
        assert then is state
        assert action is (Reaction.OBEY if state is State.WATCHING else Reaction.REFUSE)
    if event in (Event.TROUBLE, Event.REST_WANTED) and state is State.WATCHING:
        assert (then, action) == (State.RESTING, Reaction.SWITCH_OFF)
    if event is Event.REST_WANTED:
        assert action is Reaction.SWITCH_OFF  # "switch off" is never refused, whatever is believed
    if then in TOLD and state not in TOLD:
        assert action is Reaction.TELL  # nothing becomes NOT AT REST in silence
    if state in TOLD and then is State.AT_REST:
        assert action is Reaction.TELL_REST
    if event is Event.OFF_FAILED and state is not State.WATCHING:
        assert then in {State.RESTING, State.UNREACHED}  # what does not read back as off is not cooling
    if then is State.AT_REST and state is not State.AT_REST:
        assert event is Event.TOWARDS_ROOM
        assert state in {State.COOLING, State.HOT}  # read back as off, and seen to cool: both


def test_the_table_holds_every_state_and_no_dead_event() -> None:
    assert {state for state, _ in TABLE} == set(State)
    assert {event for _, event in TABLE} == set(Event)


def test_at_rest_is_reached_from_everywhere_once_the_oven_obeys_and_cools() -> None:
    for state in REST:
        for event in (Event.OFF_TAKEN, Event.TOWARDS_ROOM):
            state = after(state, event)[0]
        assert state is State.AT_REST


def test_nothing_that_fails_for_ever_stays_untold() -> None:
    """Whatever sequence of failures: after the time allowed, people are told."""
    for first in REST - {State.AT_REST}:
        for failures in product((Event.OFF_FAILED, Event.AWAY, Event.OVERDUE), repeat=4):
            state, told = first, first in TOLD
            for event in failures:
                state, action = after(state, event)
                told = told or action is Reaction.TELL
            for _ in range(2):  # at last the time of whatever state that is has passed
                state, action = after(state, Event.OVERDUE)
                told = told or action is Reaction.TELL
            assert told, (first, failures)


def test_a_model_of_oven_and_supervision_in_every_order() -> None:
    """Walk through all (supervision, true oven) pairs: none believes in rest while the oven regulates."""
    pairs, open_pairs = set(), {(State.WATCHING, "regulating", False)}
    while open_pairs:
        pair = open_pairs.pop()
        if pair in pairs:
            continue
        pairs.add(pair)
        state, oven, off_read = pair
        assert not (state is State.AT_REST and oven == "regulating" and not off_read), pair
        for event in Event:
            # events that the world allows: OFF reads back only of an oven that is off, and so on
            if event is Event.OFF_TAKEN and state is State.WATCHING:
                continue
            if event is Event.TOWARDS_ROOM and not off_read:
                continue
            now = "off" if event is Event.OFF_TAKEN else oven
            read = (off_read or event is Event.OFF_TAKEN) and event is not Event.OFF_FAILED
            open_pairs.add((after(state, event)[0], now, read))
    assert {state for state, _, _ in pairs} == set(State)
