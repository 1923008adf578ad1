from pathlib import Path

import pytest

from app.files.campaign_error import CampaignFileError
from app.files.events import append_event, read_events


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
