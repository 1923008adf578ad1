"""Commands on a report name the campaign of its run folder by a path that can be copied."""

import os
import shlex
from pathlib import Path

import pytest

from app.files.bad_file import ResultFileError
from app.files.campaigns.of_run import POINTER, campaign_of, campaign_typed, remember_campaign
from app.stages.comparison.plan import open_before


def campaign(folder: Path) -> Path:
    folder.mkdir(parents=True)
    (folder / "campaign.toml").touch()
    return folder


@pytest.mark.parametrize("name", ["plate", "Türverkleidung 2", "it's"])
def test_the_campaign_beside_is_found_by_its_name(tmp_path: Path, name: str) -> None:
    recorded = campaign(tmp_path / name)
    run = tmp_path / f"{name}-run"
    run.mkdir()
    assert shlex.split(campaign_of(run)) == [str(recorded)]
    remember_campaign(run, recorded)
    assert not (run / POINTER).exists()


def test_a_campaign_elsewhere_is_remembered_and_the_run_folder_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recorded, run = campaign(tmp_path / "data of May" / "plate"), tmp_path / "runs" / "first one"
    run.mkdir(parents=True)
    monkeypatch.chdir(tmp_path)
    remember_campaign(Path("runs/first one"), Path("data of May/plate"))
    typed = shlex.split(campaign_of(Path("runs/first one")))
    assert typed == [str(recorded), "--out", str(run)]
    moved = tmp_path / "moved"
    os.rename(tmp_path / "data of May", tmp_path / "data")  # noqa: PTH104 (a folder of both kinds of names)
    run.rename(moved)
    assert campaign_of(moved).startswith("CAMPAIGN --out ")


def test_a_damaged_pointer_is_no_error(tmp_path: Path) -> None:
    for text in ("{", "[]", '{"campaign": 3}', '{"campaign": "\\u0000"}'):
        (tmp_path / POINTER).write_text(text, encoding="utf-8")
        assert campaign_of(tmp_path).startswith("CAMPAIGN --out ")


def test_a_terminal_repeats_what_was_typed() -> None:
    assert campaign_typed(Path("a b"), None) == "'a b'"
    assert campaign_typed(Path("plate"), Path("plate-run")) == "plate"
    assert campaign_typed(Path("plate"), Path("other run")) == "plate --out 'other run'"


def test_an_earlier_run_without_a_plan_says_how_to_make_one(tmp_path: Path) -> None:
    recorded = campaign(tmp_path / "plate 1")
    run = tmp_path / "plate 1-run"
    run.mkdir()
    with pytest.raises(ResultFileError, match=r"make it with: flexura gap '.*plate 1' --plan") as raised:
        open_before(run)
    assert str(recorded) in str(raised.value)
