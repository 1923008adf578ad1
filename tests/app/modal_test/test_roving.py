"""Files of several points are not averaged as one: `new` asks, `identify` refuses, the report shows coherence."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from app.files.declarations.modal_test import read_modal_test
from app.modal_test.new_declaration import of_points
from tests.app.modal_test.conftest import Beam, hammer_files

Flexura = Callable[..., tuple[int, str, str]]
WORDS = ("--drive", "Hammer=2.25 mV/N", "--response", "Acc=100 mV/g")


@pytest.fixture
def declaration(tmp_path: Path, beam: Beam) -> Path:
    return hammer_files(tmp_path, beam, seconds=4.0, count=2)


def test_files_called_after_points_are_asked_about(declaration: Path, run_flexura: Flexura) -> None:
    files = sorted(declaration.parent.glob("point*.csv"))
    declaration.unlink()
    status, out, err = run_flexura("new", "test", *files, *WORDS)
    assert (status, out) == (2, "")
    assert "point1.csv to point5.csv are called after points: name the channel that was moved" in err
    assert "--roving Hammer (one of Hammer, Acc), or say --same-point" in err
    assert not declaration.exists()
    assert run_flexura("new", "test", *files, *WORDS, "--same-point")[0] == 0
    assert [record.at for record in read_modal_test(declaration).record] == [{}] * 5


@pytest.mark.parametrize("answer", ["Hammer", "none"])
def test_at_a_terminal_the_question_is_asked(
    declaration: Path, run_flexura: Flexura, monkeypatch: pytest.MonkeyPatch, answer: str
) -> None:
    files = sorted(declaration.parent.glob("point*.csv"))
    declaration.unlink()
    asked: list[str] = []
    monkeypatch.setattr("sys.stdin.isatty", lambda: True, raising=False)
    monkeypatch.setattr("click.prompt", lambda text, **_: asked.append(text) or answer)
    monkeypatch.setattr("app.commands.new.sys.stdin", type("Terminal", (), {"isatty": lambda self: True})())
    status, _, err = run_flexura("new", "test", *files, *WORDS)
    assert status == 0, err
    assert asked == ["point1.csv to point5.csv: which channel was moved from point to point"]
    assert [record.at for record in read_modal_test(declaration).record] == [
        {"Hammer": f"{n}:+z"} if answer == "Hammer" else {} for n in range(1, 6)
    ]


def test_one_file_and_files_of_repeats_are_not(tmp_path: Path) -> None:
    def named(*names: str) -> bool:
        return of_points([tmp_path / name for name in names])

    assert named("point1.csv", "point2.csv")
    assert named("hammer_P01.mat", "hammer_P12.mat")
    assert named("beam node 1.csv.gz", "beam node 2.csv.gz")
    for other in (("point1.csv",), ("hit1.csv", "hit2.csv"), ("run_1.csv", "run_2.csv"), ("a1.csv", "a2.csv")):
        assert not named(*other)
    assert not named("temp1.csv", "temp2.csv")  # a word that ends in a p
    assert not named("2026-01-02.csv", "2026-01-03.csv")
    assert not named("point1.csv", "all.csv")


def at_one_place(declaration: Path) -> None:
    text = declaration.read_text(encoding="utf-8")
    declaration.write_text(re.sub(r'Hammer = "\d:\+z"', 'Hammer = "1:+z"', text), encoding="utf-8")


def test_points_averaged_as_one_are_refused(declaration: Path, run_flexura: Flexura) -> None:
    at_one_place(declaration)
    status, out, err = run_flexura("identify", declaration)
    assert (status, out) == (2, "")
    assert "point1.csv, point2.csv, point3.csv and 2 more are declared at the same places, but do not agree" in err
    assert "Are they of several points? Then say where each was measured" in err
    assert not (declaration.parent / "test-run" / "modes.h5").exists()


def test_two_files_with_one_node_are_refused_by_name(declaration: Path, run_flexura: Flexura) -> None:
    text = declaration.read_text(encoding="utf-8")
    declaration.write_text(text.replace('Hammer = "4:+z"', 'Hammer = "2:+z"'), encoding="utf-8")
    status, _, err = run_flexura("identify", declaration)
    assert status == 2
    assert "point2.csv, point4.csv are declared at the same places, but do not agree: Acc by 0." in err


def test_files_of_one_point_are_averaged_and_the_report_shows_their_coherence(
    declaration: Path, beam: Beam, run_flexura: Flexura
) -> None:
    files = sorted(declaration.parent.glob("point*.csv"))
    for file in files[1:]:  # the same blows with other noise would be no repeat; the same file is the plainest one
        file.write_bytes(files[0].read_bytes())
    at_one_place(declaration)
    run = declaration.parent / "run"
    status, _, err = run_flexura("identify", declaration, "--out", run)
    assert status == 0, err
    assert "agree" not in err
    assert run_flexura("report", run)[0] == 0
    page = (run / "report.html").read_text(encoding="utf-8")
    assert "Can the FRFs be trusted?" in page
    assert re.search(r"coherence</t[dh]><t[dh][^>]*>median (1|0\.9\d*), least", page)
