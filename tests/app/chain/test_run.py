"""``flexura run``: its options, what is imported, and what is skipped, on a recording of six short sweeps."""

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from app.chain.work import STAGES, chosen_stages
from app.files.campaigns.loading import load_campaign
from app.files.results.modes_file import load_modes
from tests.app.chain.conftest import said_of, skipped
from tests.app.conftest import TinyCampaign

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def words(tiny: TinyCampaign, tmp_path: Path) -> list[str]:
    """Return how a run of a small recording begins."""
    return ["run", str(tiny.write(tmp_path / "tiny"))]


def test_a_recording_is_imported_and_its_table_run_decides(
    tiny: TinyCampaign, tmp_path: Path, run_flexura: Run
) -> None:
    folder = tiny.write(tmp_path / "tiny")
    declaration = folder / "campaign.toml"
    declaration.write_text(declaration.read_text(encoding="utf-8") + "\n[run.identify]\nband = [100.0, 900.0]\n")
    words = ("run", folder, "--until", "identify")
    status, _, message = run_flexura(*words)
    assert status == 0, message
    assert (tmp_path / "tiny-campaign" / "protocol.json").is_file()
    assert load_modes(tmp_path / "tiny-run" / "modes.h5").modes[0].band[1] <= 900.0
    assert skipped(run_flexura(*words)[2]) == {"import", "identify"}
    text = declaration.read_text(encoding="utf-8").replace("900.0]\n", "800.0]\n")
    declaration.write_text(text, encoding="utf-8")
    status, _, message = run_flexura(*words)
    assert status == 0, message
    assert skipped(message) == {"import"}  # other options do not make another recording
    declaration.write_text(text.replace("mass = 0.13", "mass = 0.14"), encoding="utf-8")
    status, _, message = run_flexura(*words)
    assert status == 0, message
    assert "6 sweeps, renewed" in said_of(message)["import"]  # it was "holds another campaign", with no way on
    assert load_campaign(tmp_path / "tiny-campaign").experiment.plate.mass == 0.14
    assert not skipped(message)


def test_a_recording_that_was_changed_is_not_judged_by_its_old_import(
    tiny: TinyCampaign, tmp_path: Path, run_flexura: Run
) -> None:
    """All stages were "up to date" with the old sweeps, and `--only identify` ended with 0."""
    folder = tiny.write(tmp_path / "tiny")
    words = ("run", folder, "--until", "identify")
    assert run_flexura(*words)[0] == 0
    before = (tmp_path / "tiny-run" / "modes.csv").read_bytes()
    tiny.files["002.tdms"].groups["repeat 1"]["S1"][700:900] *= 1.02
    (folder / "sweeps" / "002.tdms").unlink()
    tiny.files["002.tdms"].write(folder / "sweeps" / "002.tdms")
    status, _, message = run_flexura(*words)
    assert status == 1
    assert "imported from other files: sweeps/002.tdms" in said_of(message)["import"]
    assert "--set campaign=FOLDER" in said_of(message)["import"]
    assert not skipped(message)
    assert (tmp_path / "tiny-run" / "modes.csv").read_bytes() != before
    status, _, message = run_flexura("run", folder, "--only", "identify")
    assert (status, skipped(message)) == (0, {"identify"})
    shutil.rmtree(tmp_path / "tiny-campaign")
    assert run_flexura(*words)[0] == 0


def test_a_recording_that_lacks_sweeps_is_read_where_it_stands(
    tiny: TinyCampaign, tmp_path: Path, run_flexura: Run
) -> None:
    folder = tiny.write(tmp_path / "tiny")
    (folder / "sweeps" / "003.tdms").unlink()
    status, _, message = run_flexura("run", folder, "--until", "identify")
    assert status == 0, message
    assert said_of(message)["import"].startswith("5 of 6 sweeps are there: read where they are, not imported")
    assert not (tmp_path / "tiny-campaign").exists()
    assert (tmp_path / "tiny-run" / "modes.h5").is_file()


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[run]\nmain = 50.0", ("run.toml", "run.main", "unknown key", "did you mean mains?")),
        ("[run]\nmains = 5.0", ("run.toml", "run.mains = 5.0", "10", "400")),
        ("[run.focus]\ntaps = 8", ("run.toml", "run.focus.taps = 8", "16", "16384")),
        ("[run.focus]\nmethod = 'stiff'", ("run.focus.method", "'stiff'", "did you mean stif?")),
        ("[run.identify]\nband = [800.0, 100.0]", ("run.identify", "the first must be below the second")),
        ("[run.compensate]\nspacing = 4.0\nplace = 8", ("run.compensate", "name one of them")),
        ("[run]\nwithout = ['gaps']", ("run.without", "'gaps'", "identify")),
        ("title = 'no options'", ("run.toml", "run", "a table [run]")),
        ("run = 3", ("run.toml", "run", "3")),
        ("[run", ("run.toml", "line 1")),
    ],
)
def test_a_bad_option_is_named_with_file_key_and_what_is_allowed(
    words: list[str], tmp_path: Path, run_flexura: Run, text: str, told: tuple[str, ...]
) -> None:
    file = tmp_path / "run.toml"
    file.write_text(text, encoding="utf-8")
    status, output, message = run_flexura(*words, "--settings", file)
    assert (status, output) == (2, "")
    for word in told:
        assert word in message
    assert not (tmp_path / "tiny-run").exists()


@pytest.mark.parametrize(
    ("typed", "told"),
    [
        ("focus.taps=8", ("--set", "run.focus.taps = 8", "16384")),
        ("focus.taps", ("--set", "KEY=VALUE")),
        ("focus=3", ("--set", "run.focus", "3")),
        ("mains=fifty", ("--set", "run.mains", "'fifty'")),
    ],
)
def test_a_bad_typed_option_is_named(
    words: list[str], run_flexura: Run, typed: str, told: tuple[str, ...]
) -> None:
    status, output, message = run_flexura(*words, "--set", typed)
    assert (status, output) == (2, "")
    for word in told:
        assert word in message


@pytest.mark.parametrize(
    ("typed", "told"),
    [
        ("focus.panel=door.toml", "option focus.panel of [run]: "),
        ("effects=own-effects", "option effects of [run]: "),
        ("compensate.weather=july.toml", "option compensate.weather of [run]: "),
        ("compensate.device=tpu", "tpu: no device for networks; allowed: cpu"),
    ],
)
def test_what_a_later_stage_cannot_use_is_refused_before_the_first(
    words: list[str], tmp_path: Path, run_flexura: Run, typed: str, told: str
) -> None:
    status, output, message = run_flexura(*words, "--set", typed)
    assert (status, output) == (2, "")
    assert told in message
    assert not (tmp_path / "tiny-run").exists()
    assert run_flexura(*words, "--set", typed, "--until", "identify")[0] == 0  # which needs none of them


def test_stages_are_chosen() -> None:
    assert chosen_stages() == STAGES
    assert chosen_stages("update", "focus") == ("update", "gap", "focus")
    assert chosen_stages(only=("report", "import")) == ("import", "report")
    assert chosen_stages(last="gap", without=("gap", "import")) == ("identify", "update")
    with pytest.raises(ValueError, match="no stage is left"):
        chosen_stages("report", "gap")


@pytest.mark.parametrize("wrong", [{"without": ["gp"]}, {"only": ["gp"]}, {"first": "gp"}, {"last": "gp"}])
def test_a_name_that_is_no_stage_is_refused(wrong: Any) -> None:
    """One to be left out was passed over, and everything was run."""
    with pytest.raises(ValueError, match=r"'gp' is no stage; did you mean gap\? allowed: import, identify"):
        chosen_stages(**wrong)


def test_one_stage_in_place_of_a_list_is_refused() -> None:
    stages: Any = "gap"
    with pytest.raises(ValueError, match="'gap': a list of stages is wanted"):
        chosen_stages(without=stages)


def test_a_table_that_is_damaged_is_written_again(words: list[str], tmp_path: Path, run_flexura: Run) -> None:
    words += ["--until", "identify", "--set", "identify.method=peak-picking"]
    assert run_flexura(*words)[0] in (0, 1)
    table = tmp_path / "tiny-run" / "modes.csv"
    before = table.read_bytes()
    table.write_bytes(before[:50])
    _, _, message = run_flexura(*words)
    assert skipped(message) == {"import"}
    assert table.read_bytes() == before
    assert skipped(run_flexura(*words)[2]) == {"import", "identify"}
    assert skipped(run_flexura(*words, "--force")[2]) == set()


def test_a_failure_is_one_sentence_and_status_1(words: list[str], tmp_path: Path, run_flexura: Run) -> None:
    words += ["--set", "identify.band=[2000, 3000]", "--set", 'without=["update", "gap", "focus", "compensate"]']
    status, output, message = run_flexura(*words)
    assert status == 1
    said = said_of(message)
    assert said["import"].startswith("6 sweeps, imported: ")
    assert said["identify"].startswith("FAILED: ")
    assert "0 frequency lines" in said["identify"]
    assert said["report"] == "NOT RUN: there is no result yet that could be reported"
    assert "Traceback" not in output + message
    assert message.splitlines()[-1].startswith("1 stage made, failed: identify, not run: report; ")


def test_a_folder_that_is_no_campaign_is_refused_before_anything_is_made(tmp_path: Path, run_flexura: Run) -> None:
    (tmp_path / "photos").mkdir()
    status, _, message = run_flexura("run", tmp_path / "photos")
    assert status == 2
    assert "not a campaign; it holds nothing" in message
    assert not (tmp_path / "photos-run").exists()


def test_nothing_to_do_is_said(tiny: TinyCampaign, tmp_path: Path, run_flexura: Run) -> None:
    """It ended with an empty table and a line that began with a semicolon."""
    recording = tiny.write(tmp_path / "tiny")
    assert run_flexura("import", recording, "--out", tmp_path / "imported", "--quiet")[0] == 0
    status, out, err = run_flexura("run", tmp_path / "imported", "--until", "import")
    assert (status, out) == (0, "")
    assert err.startswith("nothing to do, the campaign is imported already; ")
