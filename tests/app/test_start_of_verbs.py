"""A verb answers bad input before it imports what computes, draws or drives: these take seconds."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
HEAVY = ("scipy.optimize", "scipy.signal", "scipy.sparse", "torch", "skfem", "matplotlib", "PySide6", "nidaqmx")
PROGRAM = f"""
import sys
from flexura.__main__ import main
try:
    main()
finally:
    print(*[name for name in {HEAVY} if name in sys.modules])
"""


def loaded_by(words: list[str], folder: Path, status: int) -> list[str]:
    """Heavy modules that a verb has imported when it ends with an exit status."""
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, *words],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == status, done.stderr
    return done.stdout.split()


def test_a_folder_of_other_files_is_refused_before_cards_are_loaded(tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("years")
    words = ["acquire", str(ROOT / "examples" / "simulated-rig.toml"), "--out", "mine"]
    assert {"nidaqmx", "skfem", "scipy.signal"}.isdisjoint(loaded_by(words, tmp_path, 2))


def test_a_rig_without_ni_cards_is_run_without_their_package(tmp_path: Path) -> None:
    """The simulated sound card is opened, and brought to rest."""
    words = ["safe", str(ROOT / "examples" / "sound-card.toml"), "--quiet"]
    assert "nidaqmx" not in loaded_by(words, tmp_path, 0)


@pytest.mark.parametrize(("verb", "option"), [("identify", "--export"), ("view", "--screenshot")])
def test_what_cannot_be_written_is_told_before_work_begins(verb: str, option: str, tmp_path: Path) -> None:
    (tmp_path / "notes").write_text("")
    done = subprocess.run(
        [
            sys.executable,
            "-m",
            "flexura",
            verb,
            ROOT / "examples" / "pp-plate",
            option,
            tmp_path / "notes" / "a" / "b",
        ]
        + (["--out", tmp_path / "run"] if verb == "identify" else []),
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2, done.stderr
    assert "cannot be written" in done.stderr
    assert f"name another with {option}" in done.stderr


@pytest.mark.parametrize(
    "words",
    [
        *(f"{verb} nowhere" for verb in ("update", "gap", "view", "report")),
        *(f"{verb} nowhere.toml" for verb in ("acquire", "doctor", "safe", "simulate-daq")),
    ],
)
def test_a_verb_starts_light(words: str, tmp_path: Path) -> None:
    assert loaded_by(words.split(), tmp_path, 2) == []


@pytest.mark.parametrize("words", ["focus nowhere", "compensate nowhere", "study all nowhere"])
def test_what_computes_filters_is_imported_after_the_laws_are_read(words: str, tmp_path: Path) -> None:
    """Laws are splines, for which SciPy is needed; torch, finite elements and figures are not."""
    assert set(loaded_by(words.split(), tmp_path, 2)) <= {"scipy.optimize", "scipy.sparse"}
