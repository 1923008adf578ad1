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


@pytest.mark.parametrize("words", ["update nowhere", "gap nowhere", "view nowhere"])
def test_a_verb_starts_light(words: str, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, *words.split()],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2, done.stderr
    assert done.stdout.split() == []


@pytest.mark.parametrize("words", ["focus nowhere", "compensate nowhere", "study all nowhere"])
def test_what_computes_filters_is_imported_after_the_laws_are_read(words: str, tmp_path: Path) -> None:
    """Laws are splines, for which SciPy is needed; torch, finite elements and figures are not."""
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, *words.split()],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2, done.stderr
    assert set(done.stdout.split()) <= {"scipy.optimize", "scipy.sparse"}
