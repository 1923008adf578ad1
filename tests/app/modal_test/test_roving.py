"""Files of several points are not averaged as one: `new` asks, `identify` refuses, the report shows coherence."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from app.files.declarations.modal_test import read_modal_test
from app.modal_test.new_declaration import of_points, roved_nodes
from tests.app.modal_test.conftest import RATE, Beam, blows, hammer_files

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
    assert named("pt1_hit1.csv", "pt1_hit2.csv", "pt2_hit1.csv")
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


@pytest.mark.parametrize(
    ("names", "nodes"),
    [
        (["point1", "point10", "point2"], [1, 10, 2]),  # as a shell lists them
        (["pt1_hit1", "pt1_hit2", "pt2_hit1", "pt2_hit2"], [1, 1, 2, 2]),
        (["run3 node 7", "run4 node 7", "run5 node 9"], [7, 7, 9]),
        (["p0", "p1", "p2"], [1, 2, 3]),  # nodes begin at 1
        (["4_hit1", "4_hit2", "6_hit1"], [1, 1, 2]),
        (["rec1", "rec10", "rec2"], [1, 3, 2]),
        (["rec10", "rec1", "rec2"], [1, 2, 3]),  # in an order of somebody's own
        (["2026-11-30 10-15-02", "2026-11-30 10-17-31", "2026-11-30 11-02-07"], [1, 2, 3]),
        (["left", "middle", "right"], [1, 2, 3]),
    ],
)
def test_nodes_are_those_of_the_names(names: list[str], nodes: list[int]) -> None:
    assert roved_nodes([Path(f"{name}.csv") for name in names]) == nodes


def one_file_a_hit(folder: Path, beam: Beam, noise: float) -> list[Path]:
    """Write three hits at each of four points, every second one a double hit, a file each."""
    rng, files = np.random.default_rng(3), []
    t = np.arange(round(3.0 * RATE)) / RATE
    for point in range(9, 13):
        for hit in range(1, 4):
            force = blows(rng, 3.0, 1, width=2e-3)
            if hit == 2:
                force = force + 0.3 * np.roll(force, 120)
            acc = beam.answer(force, 0, (point - 1) % 5) + noise * rng.standard_normal(len(t))
            force = force + 0.02 * rng.standard_normal(len(t))
            files.append(folder / f"pt{point}_hit{hit}.csv")
            np.savetxt(files[-1], np.column_stack([t, force, acc]), "%.7g", ",", header="Time [s],F [N],A [m/s2]")
    return sorted(files)


def test_one_file_a_hit_and_files_whose_hit_does_not_count(
    tmp_path: Path, beam: Beam, run_flexura: Flexura
) -> None:
    declaration = tmp_path / "test.toml"
    files = one_file_a_hit(tmp_path, beam, noise=0.02)
    words = ("--roving", "F", "--drive", "F=N", "--response", "A=m/s2", "--out", declaration)
    status, _, err = run_flexura("new", "test", *files, *words)
    assert status == 0, err
    assert "F at 4 points in 12 records" in err
    status, out, err = run_flexura("identify", declaration, "--out", tmp_path / "run")
    assert status == 0, err
    assert "4 FRFs" in out + err
    left_out = re.findall(r"(pt\d+_hit\d)\.csv: blow 1 of 1 left out, double hit", err)
    assert sorted(left_out) == sorted(f"pt{point}_hit2" for point in range(9, 13))
    # blows of 4 ms reach up to some 500 Hz of the 2048 that were sampled
    said = re.search(r"noise is \d+ % of the FRFs, and most of the misfit; .* --band (\d+) (\d+)", err)
    assert said is not None, err
    assert float(said[1]) < 95.0
    assert 400.0 < float(said[2]) < 900.0
    again = ("--out", tmp_path / "again", "--band", said[1], said[2])
    status, out, err = run_flexura("identify", declaration, *again)
    assert status == 0, err
    assert "noise is" not in err


def test_a_point_without_any_hit_that_counts_is_refused(tmp_path: Path, beam: Beam, run_flexura: Flexura) -> None:
    files = [one for one in one_file_a_hit(tmp_path, beam, noise=0.02) if "hit2" in one.name][:2]
    declaration = tmp_path / "test.toml"
    words = ("--roving", "F", "--drive", "F=N", "--response", "A=m/s2", "--out", declaration)
    assert run_flexura("new", "test", *files, *words)[0] == 0
    status, _, err = run_flexura("identify", declaration, "--out", tmp_path / "run")
    assert status == 2
    assert "pt10_hit2.csv: none of 1 blows counts (double hit: " in err
