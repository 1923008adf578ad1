"""JSON and TOML of bounded size and depth."""

import json
import tracemalloc
from pathlib import Path

import pytest

from app.files.acquisition import events
from app.files.acquisition.events import read_events
from app.files.campaign_error import CampaignFileError
from app.files.parsed_text import DEEPEST_NESTING, LARGEST_DECLARATION, parse_json, parse_toml, read_text
from app.files.settings_toml import read_table


def test_what_is_plain_is_parsed() -> None:
    assert parse_json(b'{"a": [1, 2.5, "x", null, true]}') == {"a": [1, 2.5, "x", None, True]}
    assert parse_toml("a = [1, 2]\n[b.c]\nd = 'e'") == {"a": [1, 2], "b": {"c": {"d": "e"}}}
    deepest = "[" * DEEPEST_NESTING + "]" * DEEPEST_NESTING
    assert json.dumps(parse_json(deepest)) == deepest


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be"])
def test_text_as_editors_write_it(tmp_path: Path, encoding: str) -> None:
    """Notepad and PowerShell write a byte order mark, or UTF-16."""
    file = tmp_path / "mine.toml"
    file.write_text("title = 'Türverkleidung, 20 °C'\n", encoding=encoding)
    assert read_table(file) == {"title": "Türverkleidung, 20 °C"}


@pytest.mark.parametrize("depth", [DEEPEST_NESTING + 1, 900, 100_000])
def test_what_is_nested_without_end_is_refused(depth: int) -> None:
    with pytest.raises(ValueError, match="nested more than 32 deep"):
        parse_json("[" * depth + "]" * depth)
    with pytest.raises(ValueError, match="nested more than 32 deep"):
        parse_json('{"a":' * depth + "1" + "}" * depth)
    with pytest.raises(ValueError, match="nested more than 32 deep"):
        parse_toml("a = " + "[" * depth + "]" * depth)


def test_tables_named_by_very_many_keys_are_refused() -> None:
    with pytest.raises(ValueError, match="nested more than 32 deep"):
        parse_toml(".".join(["a"] * 2000) + " = 1")


@pytest.mark.parametrize("text", ["NaN", "[Infinity]", '{"a": -Infinity}'])
def test_json_has_no_nan(text: str) -> None:
    with pytest.raises(ValueError, match="no number of JSON"):
        parse_json(text)


def test_no_more_is_read_than_allowed(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    path.write_text("#" * LARGEST_DECLARATION)
    assert len(read_text(path)) == LARGEST_DECLARATION
    path.write_text("#" * (LARGEST_DECLARATION + 1))
    with pytest.raises(ValueError, match="1000001 bytes; allowed: at most 1000000"):
        read_text(path)
    with pytest.raises(CampaignFileError, match=r"a\.toml: 1000001 bytes"):
        read_table(path)


def test_a_small_file_takes_little_memory_however_much_is_allowed(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text("[1]")
    tracemalloc.start()
    assert read_text(tmp_path / "a.json", 2_000_000_000) == "[1]"
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 10_000_000


@pytest.mark.parametrize("text", ["[" * 100_000, '{"wish":' * 500 + "1" + "}" * 500, "[]", '{"wish": ["stop"]}'])
def test_no_request_disturbs_a_runner(tmp_path: Path, text: str) -> None:
    (tmp_path / events.CONTROL).write_text(text)
    assert events.requested(tmp_path) == "go on"


def test_a_log_of_nested_events_is_refused(tmp_path: Path) -> None:
    (tmp_path / "events.jsonl").write_text('{"event": "begun"}\n{"event": ' + "[" * 5000 + "]" * 5000 + "}\n")
    with pytest.raises(CampaignFileError, match=r"events\.jsonl: line 2"):
        read_events(tmp_path)
