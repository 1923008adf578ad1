"""A verb refuses bad input before it imports what reads, computes, draws or drives: these take seconds."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from app.main import VERBS

ROOT = Path(__file__).resolve().parents[2]
COMPUTES = ("scipy", "torch", "skfem", "matplotlib", "PySide6", "nidaqmx", "grpc", "serial")
READS = ("numpy", "pydantic", "h5py", "nptdms", "pyuff", "rich")
ABSENT = {
    **dict.fromkeys(
        ("run", "import", "identify", "update", "gap", "focus", "compensate", "report", "view"), "nowhere"
    ),
    **dict.fromkeys(("acquire", "safe", "doctor", "check-instrument", "simulate-daq"), "nowhere.toml"),
    **dict.fromkeys(("watch", "status", "examples"), "nowhere"),
    "new": "test nowhere.csv",
    "export": "nowhere --to c",
    "radiation": "nowhere",
    "render": "nowhere.wav --temperature 20",
    "thermometer": "nowhere --simulate nowhere.wav --temperature 20",
    "health": "nowhere --baseline nowhere",
    "study": "all nowhere",
    "blind-trial": "--count 1 --seed 1 --out notes/trial",
    "demo": "--out notes/demo",
    "completion": "nowhere",
}
"""For each verb: words that name what is not there, or a folder that cannot be made, as notes is a file."""
HOLLOW = {
    **{verb: words for verb, words in ABSENT.items() if words == "nowhere"},
    "export": "nowhere --to c",
    "render": "notes nowhere --temperature 20",
    "thermometer": "nowhere --simulate notes --temperature 20",
    "health": "nowhere --baseline nowhere",
    "study": "all nowhere",
    "gap --twin": "nowhere --twin notes",
    "focus --panel": "nowhere --panel notes",
    "identify --twin": f"{ROOT / 'examples' / 'pp-plate'} --twin nowhere",
}
"""For verbs that read a folder: words that name one in which nothing is."""
PROGRAM = f"""
import sys
from flexura.__main__ import main
try:
    main()
finally:
    print(*[name for name in {COMPUTES + READS} if name in sys.modules])
"""


def loaded_by(words: list[str], folder: Path, status: int) -> list[str]:
    """Modules, of those that compute and those that read, that a verb has imported when it ends."""
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


def test_every_verb_is_tried() -> None:
    assert set(ABSENT) == set(VERBS)


@pytest.mark.parametrize("verb", VERBS)
def test_what_is_not_there_is_told_before_anything_is_imported(verb: str, tmp_path: Path) -> None:
    (tmp_path / "notes").write_text("")
    assert loaded_by([verb, *ABSENT[verb].split()], tmp_path, 2) == []


@pytest.mark.parametrize("verb", HOLLOW)
def test_a_folder_of_another_kind_is_told_before_what_computes_is_imported(verb: str, tmp_path: Path) -> None:
    (tmp_path / "notes").write_text("")
    (tmp_path / "nowhere").mkdir()
    words = [verb.partition(" ")[0], *HOLLOW[verb].split()]
    assert set(COMPUTES).isdisjoint(loaded_by(words, tmp_path, 2))


def test_windows_on_campaigns_need_nothing_that_computes() -> None:
    """Pages import it when they are looked at."""
    pytest.importorskip("PySide6.QtSvg", exc_type=ImportError)
    code = "import sys, app.view.recorded.window, app.view.live.window; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert set(COMPUTES) & set(done.stdout.split()) == {"PySide6"}


def test_a_script_loads_nothing_that_draws_on_a_terminal() -> None:
    code = """
import sys
import flexura
from app.stages import compensate, focus, gap, identify, update, update_modes
from app.terminal.progress import progress
functions = [getattr(flexura, name) for name in flexura.__all__]
with progress(shown=None) as report:
    report("sweeps", 0.5)
print(*sys.modules)
"""
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert {"rich", "click"} & set(done.stdout.split()) == set()
