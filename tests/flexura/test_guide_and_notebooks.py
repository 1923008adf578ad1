"""The library's page says what happens, and the notebooks run from top to bottom."""

import doctest
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "guide" / "library.md"
NOTEBOOKS = ROOT / "examples" / "notebooks"


def test_the_page_gives_what_it_shows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    done = doctest.testfile(str(PAGE), module_relative=False, encoding="utf-8")
    assert done.attempted > 8
    assert done.failed == 0


def test_the_page_lists_every_function_and_figure() -> None:
    import flexura
    from flexura.figures import FIGURES

    page = PAGE.read_text(encoding="utf-8")
    assert [name for name in flexura.__all__ if f"`flexura.{name}" not in page] == []
    for value, kinds in FIGURES.items():
        (row,) = [line for line in page.splitlines() if f".{value.__name__}`" in line]
        assert row.endswith(", ".join(f"`{kind}`" for kind in kinds) + " |")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("script", "said", "made"),
    [
        ("analyse_a_campaign.py", "E at 20 °C: ", "analysed/before.png"),
        ("close_a_gap.py", "GapComparison: gap explained by point_mass", "puzzle-run/residual.png"),
    ],
)
def test_a_notebook_runs(script: str, said: str, made: str, tmp_path: Path) -> None:
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, str(NOTEBOOKS / script)],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert said in done.stdout
    assert (tmp_path / made).is_file()
