"""``flexura run`` of many campaigns: which are meant, what each comes to, what is not made again."""

import json
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from app.fleet.fleet_run import RunMember
from tests.app.conftest import TinyCampaign

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def campaigns(tiny: TinyCampaign, tmp_path: Path) -> Path:
    """Return a folder of two recordings."""
    folder = tmp_path / "doors"
    for name in ("first", "second"):
        tiny.write(folder / name)
    (folder / "remarks").mkdir()
    return folder


def test_a_folder_and_a_list_are_run_and_not_made_again(campaigns: Path, tmp_path: Path, run_flexura: Run) -> None:
    words = ("run", campaigns, "--until", "identify", "--workers", 1)
    status, _, told = run_flexura(*words)
    assert status == 0, told
    folder = tmp_path / "doors-fleet"
    for name in ("first", "second"):
        assert (folder / name / "modes.h5").is_file()
        assert f"{name}: 2 stages made" in told
    page = (folder / "fleet.html").read_text(encoding="utf-8")
    assert "The pieces cannot be compared" in page
    listed = tmp_path / "list.txt"
    listed.write_text("# of June\ndoors/second\ndoors/first  # the better one\n", encoding="utf-8")
    status, out, told = run_flexura("run", listed, "--until", "identify", "--out", folder, "--json")
    assert status == 0, told
    record = json.loads(out)
    assert [one["name"] for one in record["pieces"]] == ["second", "first"]
    assert {one["said"] for one in record["pieces"]} == {"up to date"}
    assert record == json.loads((folder / "fleet.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize(("states", "said"), [(("made",), "1 stage made"), (("made", "made"), "2 stages made")])
def test_the_stages_of_a_piece_are_counted(tmp_path: Path, states: tuple[str, ...], said: str) -> None:
    stages: Any = {
        str(n): SimpleNamespace(state=state, whole=True, good=True, said="") for n, state in enumerate(states)
    }
    assert RunMember("door", tmp_path, tmp_path, stages).said == said


def test_a_campaign_that_cannot_be_read_stops_no_other(campaigns: Path, run_flexura: Run, tmp_path: Path) -> None:
    declaration = campaigns / "first" / "campaign.toml"
    declaration.write_text(declaration.read_text(encoding="utf-8").replace("mass = 0.13", "mass = -1"))
    status, out, told = run_flexura("run", campaigns, "--until", "identify", "--out", tmp_path / "out", "--json")
    assert status == 1
    first, second = json.loads(out)["pieces"]
    assert not first["good"]
    assert "mass" in first["said"]
    assert second["good"]
    assert "Traceback" not in told


def test_a_folder_that_disappears_is_one_sentence(campaigns: Path, run_flexura: Run, tmp_path: Path) -> None:
    """Between the command and the work: the sweeps of one campaign are gone."""
    for sweep in (campaigns / "second" / "sweeps").iterdir():
        sweep.unlink()
    status, out, told = run_flexura("run", campaigns, "--until", "identify", "--out", tmp_path / "out", "--json")
    assert status == 1
    assert [one["good"] for one in json.loads(out)["pieces"]] == [True, False]
    assert "Traceback" not in told


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("doors/remarks",), "not a campaign; it holds nothing"),
        (("doors/first", "doors/remarks"), "no campaign, nor a folder of campaigns; allowed: folders with"),
        (("doors/first", "other/first"), "have one name, and results are called by it"),
        (("doors/first", "doors/../doors/first"), "is named twice: name each piece once"),
        (("empty.txt",), "the list is empty; allowed: one folder a line"),
        (("wrong.txt",), "line 2: nowhere is no campaign"),
        (("binary.txt",), "the list cannot be read"),
        (("doors/first", "--workers", "2"), "--workers and --cluster are for several campaigns"),
        (("doors", "--workers", "2", "--cluster", "tcp://127.0.0.1:9"), "name one"),
        (("doors", "--cluster", "nonsense"), "--cluster nonsense: nonsense is no address"),
    ],
)
def test_bad_input_is_one_sentence(
    words: tuple[str, ...],
    said: str,
    campaigns: Path,
    tiny: TinyCampaign,
    tmp_path: Path,
    run_flexura: Run,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    tiny.write(tmp_path / "other" / "first")
    (tmp_path / "empty.txt").write_text("# nothing\n")
    (tmp_path / "wrong.txt").write_text("doors/first\nnowhere\n")
    (tmp_path / "binary.txt").write_bytes(b"\xff\xfe\x00\xd8\x41\x00")
    if "nonsense" in words:
        pytest.importorskip("distributed")
    status, _, told = run_flexura("run", *words)
    assert status == 2, told
    assert said in " ".join(told.split())
    assert "Traceback" not in told
