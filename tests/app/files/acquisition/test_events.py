from pathlib import Path

import pytest

from app.files.acquisition.events import append_event, parse_event, read_events
from app.files.campaign_error import CampaignFileError


def test_events_come_back_in_order(tmp_path: Path) -> None:
    assert read_events(tmp_path) == []
    for n in range(3):
        append_event(tmp_path, {"event": "swept", "place": f"{n} °C"})
    assert [event["place"] for event in read_events(tmp_path)] == ["0 °C", "1 °C", "2 °C"]


@pytest.mark.parametrize("torn", [b'{"ev', b'{"event": "\xc2', b"{"])
def test_torn_line_is_ignored_and_then_closed_off(tmp_path: Path, torn: bytes) -> None:
    append_event(tmp_path, {"event": "first"})
    with (tmp_path / "events.jsonl").open("ab") as file:
        file.write(torn)
    assert read_events(tmp_path) == [{"event": "first"}]
    append_event(tmp_path, {"event": "second"})
    assert read_events(tmp_path) == [{"event": "first"}, {"event": "second"}]


@pytest.mark.parametrize("line", ["nonsense", "[1, 2]", ""])
def test_damage_before_the_last_line_is_no_kill(tmp_path: Path, line: str) -> None:
    (tmp_path / "events.jsonl").write_text(f'{{"event": "first"}}\n{line}\n{{"event": "third"}}\n')
    with pytest.raises(CampaignFileError, match=r"events\.jsonl: line 2 = "):
        read_events(tmp_path)


@pytest.mark.parametrize(
    "line",
    [
        '{"step": 1}',
        '{"event": 3}',
        '{"event": "oven", "date": "2026-01-05T08:00:00"}',
        '{"event": "oven", "command": "ramp"}',
        '{"event": "oven", "command": "ramp", "target": 20.0, "rate": 0}',
        '{"event": "oven", "command": "ramp", "target": 1e300}',
        '{"event": "finished", "step": -1}',
        '{"event": "finished", "date": "2026-13-05T08:00:00"}',
        '{"event": "missing"}',
        '{"event": "sweep begun", "step": 1}',
        '{"event": "temperature in doubt", "step": 1}',
        '{"event": "temperature in doubt", "step": 1, "what": "drifts"}',
        '{"event": "temperature in doubt", "step": 1, "what": [5]}',
        '{"event": "hit", "step": 1, "doubt": 5}',
    ],
)
def test_an_event_that_its_readers_could_not_take_is_refused(tmp_path: Path, line: str) -> None:
    with pytest.raises(ValueError, match=r"event|oven|rate|target|step|date|missing|lacks|what|doubt"):
        parse_event(line)
    (tmp_path / "events.jsonl").write_text(f'{line}\n{{"event": "third"}}\n')
    with pytest.raises(CampaignFileError, match=r"events\.jsonl: line 1 = "):
        read_events(tmp_path)


def test_events_of_a_rig_are_taken(tmp_path: Path) -> None:
    common = {"time": 0.0, "date": "2026-01-05T08:00:00+00:00", "leg": -1}
    logged = [
        {"event": "begun", **common, "finished": 0},
        {"event": "oven", "command": "ramp", **common, "target": -10, "rate": 0.4, "purpose": "to the start"},
        {"event": "sweep begun", **common, "step": 0, "place": "10 °C up 1 V", "attempt": 1},
        {"event": "missing", **common, "step": 0, "place": "10 °C up 1 V", "why": "the ramp passed it"},
        {"event": "oven", "command": "hold", **common, "purpose": "pause"},
        {"event": "oven", "command": "safe", **common, "purpose": "the end", "unsafe": []},
    ]
    for event in logged:
        append_event(tmp_path, event)
    assert read_events(tmp_path) == logged
