"""``flexura run`` with all stages: what it makes is what the verbs make, and a failure stays alone."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from app.files.folder_lock import folder_lock
from app.files.results.laws_file import load_updated
from app.files.results.modes_file import load_modes
from app.files.results.panel_files import load_compensation, load_focusing
from tests.app.chain.conftest import RunOnce, said_of, skipped

pytestmark = pytest.mark.slow
Run = Callable[..., tuple[int, str, str]]
MADE = ("identify", "update", "focus", "compensate", "report")


def bytes_in(run: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(run.iterdir())}


def test_one_command_gives_the_numbers_of_the_six(whole: RunOnce, tmp_path: Path, run_flexura: Run) -> None:
    verbs = tmp_path / "verbs"
    for words in (
        ("identify", whole.campaign, "--out", verbs),
        ("update", whole.campaign, "--out", verbs),
        ("focus", verbs, "--panel", whole.panel),
        ("compensate", verbs),
        ("report", verbs),
    ):
        status, _, message = run_flexura(*words, "--quiet")
        assert status == 0, message
    ours, theirs = (load_modes(folder / "modes.h5") for folder in (whole.run, verbs))
    np.testing.assert_array_equal(ours.poles, theirs.poles)
    updated, other = (load_updated(folder / "laws.h5")[0] for folder in (whole.run, verbs))
    np.testing.assert_allclose(updated.constants, other.constants, rtol=1e-11)
    filters, others = (load_focusing(folder / "filters.h5")[1] for folder in (whole.run, verbs))
    np.testing.assert_allclose(
        filters.bank.taps, others.bank.taps, rtol=1e-6, atol=1e-9 * abs(filters.bank.taps).max()
    )
    found, known = (load_compensation(folder / "compensation.h5")[1] for folder in (whole.run, verbs))
    np.testing.assert_allclose(found.largest_loss, known.largest_loss, rtol=1e-3, atol=1e-6)
    ours_page, page = ((folder / "report.html").read_text(encoding="utf-8") for folder in (whole.run, verbs))
    assert ours_page.count("<figure") == page.count("<figure")


def test_the_record_says_what_was_made_from_what(whole: RunOnce) -> None:
    record = whole.record()
    assert record["schema"] == "flexura-run/1"
    assert whole.states() == dict.fromkeys(MADE, "made")
    for stage in record["stages"].values():
        assert stage["inputs"]
        assert stage["results"]
        assert stage["seconds"] > 0.0
        assert set(stage["versions"]) == {"flexura", "python", "packages"}
    assert record["stages"]["compensate"]["seed"] == 0
    assert record["stages"]["update"]["settings"] == {"mains": 50.0}
    found = dict(record["found"])
    assert "GPa" in found["the plate"]
    assert "±" in found["the plate"]
    assert {"modes", "twin and plate", "filters", "at any temperature", "report", "next"} <= set(found)


def test_what_is_up_to_date_is_skipped_and_said(once: RunOnce, run_flexura: Run) -> None:
    before = bytes_in(once.run)
    status, output, message = run_flexura(*once.words, "--without", "gap")
    assert status == 0, message
    assert skipped(message) == set(MADE)
    assert bytes_in(once.run) == before
    assert "GPa" in output
    assert message.splitlines()[-1].startswith("5 up to date; ")


@pytest.mark.parametrize(
    ("change", "again"),
    [
        ("focus.taps=32", {"focus", "compensate", "report"}),
        ("compensate.restarts=2", {"compensate", "report"}),
        ("report.pictures=true", {"report"}),
    ],
)
def test_another_option_makes_again_what_depends_on_it(
    once: RunOnce, run_flexura: Run, change: str, again: set[str]
) -> None:
    status, _, message = run_flexura(*once.words, "--without", "gap", "--set", change)
    assert status in (0, 1), message  # networks for 32 taps may lose more than is good enough
    assert set(said_of(message)) - skipped(message) == again
    if "taps" in change:
        assert load_focusing(once.run / "filters.h5")[1].bank.taps.shape[2] == 32


def test_another_panel_file_makes_the_filters_again(once: RunOnce, run_flexura: Run) -> None:
    text = once.panel.read_text(encoding="utf-8")
    once.panel.write_text(text.replace("taps = 64", "taps = 96"), encoding="utf-8")
    _, _, message = run_flexura(*once.words, "--until", "focus", "--without", "gap")
    assert skipped(message) == {"identify", "update"}
    assert load_focusing(once.run / "filters.h5")[1].bank.taps.shape[2] == 96


@pytest.mark.parametrize("name", ["laws.h5", "modes.csv"])
def test_a_result_that_is_gone_or_damaged_is_made_again(once: RunOnce, run_flexura: Run, name: str) -> None:
    before = (once.run / name).read_bytes()
    (once.run / name).write_bytes(before[: len(before) // 2])
    status, _, message = run_flexura(*once.words, "--until", "update")
    assert status == 0, message
    made = {"laws.h5": "update", "modes.csv": "identify"}[name]
    assert made not in skipped(message)
    assert (once.run / name).read_bytes() == before


def test_an_unreadable_record_costs_only_time(once: RunOnce, run_flexura: Run) -> None:
    (once.run / "run.json").write_text('{"schema": "flexura-run/1", "stages": 3}', encoding="utf-8")
    status, _, message = run_flexura(*once.words, "--until", "update")
    assert status == 0, message
    assert said_of(message)["update"] == "up to date; made by flexura update"  # its provenance says so
    assert once.states() == {"identify": "made", "update": "made"}


def test_forced_stages_are_made_again(once: RunOnce, run_flexura: Run) -> None:
    (once.run / "report.html").write_text("mine", encoding="utf-8")
    status, _, message = run_flexura(*once.words, "--only", "report", "--force")
    assert status == 0, message
    assert set(said_of(message)) == {"report"}
    assert skipped(message) == set()
    assert "<figure" in (once.run / "report.html").read_text(encoding="utf-8")
    assert set(once.states()) == set(MADE)  # the record of the others stays


def test_results_of_the_verbs_are_recognised(fresh: RunOnce, run_flexura: Run) -> None:
    for verb in ("identify", "update"):
        assert run_flexura(verb, fresh.campaign, "--out", fresh.run, "--quiet")[0] == 0
    before = bytes_in(fresh.run)
    status, _, message = run_flexura(*fresh.words, "--until", "update")
    assert status == 0, message
    assert skipped(message) == {"identify", "update"}
    assert {name: held for name, held in bytes_in(fresh.run).items() if name != "run.json"} == before
    status, _, message = run_flexura(*fresh.words, "--until", "update", "--set", "identify.band=[100, 400]")
    assert status == 0, message
    assert skipped(message) == set()  # other modes are paired by update


def test_what_a_verb_made_with_other_options_is_not_taken_for_ours(once: RunOnce, run_flexura: Run) -> None:
    words = ("identify", once.campaign, "--out", once.run, "--band", "100", "400", "--quiet")
    assert run_flexura(*words)[0] == 0
    _, _, message = run_flexura(*once.words, "--until", "identify")
    assert skipped(message) == set()
    assert load_modes(once.run / "modes.h5").modes[0].band[1] > 500.0


def test_more_sweeps_are_taken_in(fresh: RunOnce, run_flexura: Run, tmp_path: Path) -> None:
    last = max((fresh.campaign / "sweeps").iterdir())
    shutil.move(last, tmp_path)
    with folder_lock(fresh.campaign):
        status, _, message = run_flexura(*fresh.words, "--until", "update")
        assert status == 0, message
    assert len(load_updated(fresh.run / "laws.h5")[0].temperature) == 3
    shutil.move(tmp_path / last.name, fresh.campaign / "sweeps")
    status, _, message = run_flexura(*fresh.words, "--until", "update")
    assert status == 0, message
    assert skipped(message) == set()
    assert len(load_updated(fresh.run / "laws.h5")[0].temperature) == 4


def test_a_stage_that_fails_leaves_the_others_alone(fresh: RunOnce, run_flexura: Run) -> None:
    words = (*fresh.words, "--without", "gap", "--set", "identify.band=[700, 800]")
    status, out, message = run_flexura(*words)
    assert status == 1
    said = said_of(message)
    row = out.partition("not made")[2]
    assert "identify:" in row
    assert "0 frequency lines" in row
    assert said["identify"].startswith("FAILED: ")
    assert "700 800: 0 frequency lines; at least 8 are needed" in said["identify"]
    assert "Traceback" not in message
    states = fresh.states()
    assert states.pop("identify") == "failed"
    assert states == dict.fromkeys(MADE[1:], "made")
    assert "failed: identify" in message.splitlines()[-1]


def test_without_laws_nothing_is_designed_and_what_stands_stays(
    once: RunOnce, run_flexura: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    from app.files.bad_file import ResultFileError
    from app.stages import update

    def refuse(*_: object, **__: object) -> None:
        raise ResultFileError("plate: cannot be judged: this is a test")

    before = {name: (once.run / name).read_bytes() for name in ("laws.h5", "filters.h5", "modes.h5")}
    monkeypatch.setattr(update, "updated_twin", refuse)
    status, _, message = run_flexura(*once.words, "--from", "update", "--force")
    assert status == 1
    said = said_of(message)
    assert said["update"] == "FAILED: plate: cannot be judged: this is a test"
    for stage in ("gap", "focus", "compensate"):
        assert said[stage] == "NOT RUN: it needs update, which has no result"
    assert not said["report"].startswith(("FAILED", "NOT RUN"))
    for name in ("laws.h5", "filters.h5"):
        assert (once.run / name).read_bytes() == before[name]
    monkeypatch.undo()
    status, _, message = run_flexura(*once.words, "--without", "gap")
    assert status == 0, message
    assert "FAILED" not in message


def test_filters_that_fail_do_not_keep_networks_from_the_panel_that_was_asked_for(
    once: RunOnce, run_flexura: Run
) -> None:
    words = (*once.words, "--without", "gap", "--set", "focus.temperatures=[99.0]")
    status, _, message = run_flexura(*words)
    assert status == 1
    assert "--temperature 99 °C is outside the laws' range" in said_of(message)["focus"]
    assert once.states()["compensate"] == "made"


def test_typed_options_replace_those_of_the_file(once: RunOnce, tmp_path: Path, run_flexura: Run) -> None:
    (tmp_path / "run.toml").write_text('[run]\nwithout = ["gap"]\n[run.focus]\ntaps = 96\ndelay = 40\n')
    words = (*once.words, "--settings", tmp_path / "run.toml", "--set", "focus.taps=128", "--only", "focus")
    status, _, message = run_flexura(*words)
    assert status == 0, message
    panel, found, _ = load_focusing(once.run / "filters.h5")
    assert found.bank.taps.shape[2] == 128
    assert panel.filters.delay == 40


def test_a_stage_without_what_it_starts_from_says_what_makes_it(fresh: RunOnce, run_flexura: Run) -> None:
    status, _, message = run_flexura(*fresh.words, "--from", "focus")
    assert status == 1
    said = said_of(message)
    assert "make it with: flexura update" in said["focus"]
    assert said["report"].startswith("NOT RUN: ")


def test_json_is_the_record(once: RunOnce, run_flexura: Run) -> None:
    status, output, message = run_flexura(*once.words, "--without", "gap", "--json", "--quiet")
    assert (status, message) == (0, "")
    printed = json.loads(output)
    assert {name: stage["state"] for name, stage in printed["stages"].items()} == dict.fromkeys(MADE, "up to date")
    held = once.record()
    assert printed["found"] == held["found"]


def test_the_gap_is_told_in_words_and_what_it_corrects_is_used(fresh: RunOnce, run_flexura: Run) -> None:
    status, _, message = run_flexura(*fresh.words)
    assert status == 0, message
    record = fresh.record()
    gap = json.loads((fresh.run / "gap.json").read_text(encoding="utf-8"))
    assert gap["verdict"] in ("none", "explained")
    assert record["stages"]["gap"]["state"] == "made"
    assert any("twin" in said for _, said in record["found"])
    other = fresh.run.with_name("other")
    assert run_flexura("identify", fresh.campaign, "--out", other, "--quiet")[0] == 0
    assert run_flexura("gap", fresh.campaign, "--out", other, "--quiet")[0] == 0
    theirs = json.loads((other / "gap.json").read_text(encoding="utf-8"))
    for key in ("verdict", "effects", "gap"):
        assert gap[key] == theirs[key]  # the fit of the update stage was used, and is the same
    status, _, message = run_flexura(*fresh.words)
    assert status == 0, message
    assert skipped(message) == {*MADE, "gap"}
