import math
from pathlib import Path

import pytest

from app.files.acquisition.events import (
    CONTROL,
    ReadingLine,
    Tail,
    append_reading,
    parse_reading,
    request,
    requested,
)


def test_only_whole_new_lines_are_told_once(tmp_path: Path) -> None:
    path = tmp_path / "log"
    tail = Tail(path)
    assert tail.lines() == []
    path.write_bytes(b"one\ntwo\nthr")
    assert tail.lines() == ["one", "two"]
    assert tail.lines() == []
    with path.open("ab") as file:
        file.write("ee °C\n".encode())
    assert tail.lines() == ["three °C"]


def test_readings_come_back_and_torn_ones_do_not(tmp_path: Path) -> None:
    lines = [
        ReadingLine("2026-01-01T10:00:00+00:00", 21.5, math.nan, 'way to "0" °C, slowly', 0, 7, 3600.0),
        ReadingLine("2026-01-01T10:00:05+00:00", 21.25, 20.5, "up to 10 °C", 1, 7, 3500.5),
    ]
    for line in lines:
        append_reading(tmp_path, line)
    text = (tmp_path / "readings.csv").read_text(encoding="utf-8").splitlines()
    assert parse_reading(text[0]) is None
    first, second = (parse_reading(line) for line in text[1:])
    assert first is not None
    assert math.isnan(first.plate_c)
    assert first.stage == lines[0].stage
    assert second == lines[1]
    assert parse_reading(text[2][:30]) is None
    for wrong in (
        text[2].replace("2026-01", "2026-13"),
        text[2].replace("3500.5", "inf"),
        text[2].replace(",7,", ",0,"),
    ):
        assert parse_reading(wrong) is None


@pytest.mark.parametrize("content", ["", "{", "[]", '{"wish": "explode"}', '{"wish": null}', "\x00"])
def test_a_request_that_cannot_be_read_disturbs_nothing(tmp_path: Path, content: str) -> None:
    (tmp_path / CONTROL).write_text(content, encoding="utf-8")
    assert requested(tmp_path) == "go on"


def test_a_request_stands_until_it_is_taken_back(tmp_path: Path) -> None:
    assert requested(tmp_path) == "go on"
    request(tmp_path, "pause")
    assert requested(tmp_path) == "pause"
    request(tmp_path, "stop")
    assert requested(tmp_path) == "stop"
    request(tmp_path, "go on")
    request(tmp_path, "go on")
    assert requested(tmp_path) == "go on"
    assert not list(tmp_path.iterdir())
