import pytest
from nidaqmx.error_codes import DAQmxErrors

from drivers.ni.cards import KNOWN_ERRORS, Action, from_status

ACTIONS = {
    Action.RETRY_DISCARD: (-200279, -200361, -200010, -200019, -200290, -200018, -200621),
    Action.RETRY_ONCE: (-200284, -200560),
    Action.STOP: (-200077, -200452, -200265, -200561, -89120),
    Action.LIST_EXISTING: (-200170, -200220),
    Action.RESERVED: (-50103, -200022),
    Action.LOST_DEVICE: (-201003, -200324, -88705, -88709, -88710, -50405),
}


def test_table_is_complete_and_each_status_stands_once() -> None:
    codes = [error.code for error in KNOWN_ERRORS]
    assert sorted(codes) == sorted(code for group in ACTIONS.values() for code in group)


@pytest.mark.parametrize("known", KNOWN_ERRORS, ids=lambda known: known.name)
def test_names_are_the_vendors(known: object) -> None:
    assert DAQmxErrors(known.code).name == known.name  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("action", "code"), [(action, code) for action, group in ACTIONS.items() for code in group]
)
def test_each_status_calls_for_its_action(action: Action, code: int) -> None:
    error = from_status("the sweep", code, "Something.\n\n  Task Name: t")
    assert error.action is action
    assert error.code == code
    assert str(code) in str(error)
    assert "Something. Task Name: t" in str(error)
    assert error.next_step in str(error)


def test_retries_are_bounded_and_only_where_they_can_help() -> None:
    assert {action: action.retries for action in Action if action.retries} == {
        Action.RETRY_DISCARD: 3,
        Action.RETRY_ONCE: 1,
    }


def test_unknown_status_stops() -> None:
    error = from_status("the sweep", -209999, "What is this?")
    assert error.action is Action.STOP
    assert "-209999" in str(error)


def test_what_exists_is_told_for_a_wrong_name_only() -> None:
    assert "cDAQ1Mod1/ai0" in str(from_status("setting up", -200220, "No.", ("cDAQ1Mod1/ai0",)))
    assert "cDAQ1Mod1/ai0" not in str(from_status("setting up", -200077, "No.", ("cDAQ1Mod1/ai0",)))
