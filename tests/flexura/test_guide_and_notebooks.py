"""The library's page says what happens, and the notebooks run from top to bottom."""

import doctest
import importlib.util
import json
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


def test_the_notebooks_are_those_of_the_scripts() -> None:
    spec = importlib.util.spec_from_file_location("make_notebooks", ROOT / "docs" / "make_notebooks.py")
    assert spec is not None
    assert spec.loader is not None
    maker = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(maker)
    scripts = sorted(NOTEBOOKS.glob("*.py"))
    assert scripts
    for script in scripts:
        assert script.with_suffix(".ipynb").read_text(encoding="utf-8") == maker.notebook(script)


def test_a_table_of_a_notebook_is_one_table_and_its_cells_are_escaped() -> None:
    from app.summaries.table import Table, as_html

    table = Table("modes < 100 Hz", ("mode", "why"), (("95.0 Hz", "a < b"),), words=frozenset({1}))
    page = as_html("one", [table])
    assert page.count("<table>") == page.count("95.0 Hz") == 1
    assert "modes &lt; 100 Hz" in page
    assert ">a &lt; b</td>" in page
    assert "rich" not in page


def test_a_figure_shows_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    import flexura

    figure = flexura.plot(flexura.frf(flexura.example("pp-plate")))
    assert figure._repr_png_().startswith(b"\x89PNG")  # type: ignore[attr-defined]


def test_examples_are_found_by_name_and_others_are_listed() -> None:
    import flexura

    assert (flexura.example("hidden-effect.toml")).is_file()
    for bad in ("none", "", "../setup.cfg", "/etc/passwd"):
        with pytest.raises(ValueError, match=r"no example .*pp-plate"):
            flexura.example(bad)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["analyse_a_campaign", "close_a_gap"])
def test_a_notebook_runs_in_jupyter_and_shows_each_value_once(name: str, tmp_path: Path) -> None:
    """With the extra notebooks, in this environment or in one whose Python FLEXURA_JUPYTER names."""
    python = os.environ.get("FLEXURA_JUPYTER", sys.executable)
    found = "import ipykernel, nbconvert"
    if subprocess.run([python, "-c", found], capture_output=True, check=False).returncode:
        pytest.skip("needs the extra notebooks: ipykernel, nbconvert")
    words = ["-m", "nbconvert", "--to", "notebook", "--execute", "--output-dir", str(tmp_path)]
    work = tmp_path / "work"  # a notebook runs in its own folder
    work.mkdir()
    (work / f"{name}.ipynb").write_bytes((NOTEBOOKS / f"{name}.ipynb").read_bytes())
    environment = os.environ | {
        "PYTHONPATH": str(ROOT),
        "PATH": f"{Path(python).parent}{os.pathsep}{os.environ['PATH']}",
    }
    done = subprocess.run(
        [python, *words, str(work / f"{name}.ipynb")], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    cells = json.loads((tmp_path / f"{name}.ipynb").read_text(encoding="utf-8"))["cells"]
    outputs = [
        [one for one in cell["outputs"] if "".join(one.get("data", {}).get("text/html", "x"))]
        for cell in cells
        if cell["cell_type"] == "code"
    ]
    assert max(len(one) for one in outputs) == 1  # each value once; bars of progress are gone
    assert [one for cell in outputs for one in cell if one.get("name") == "stderr"] == []
    drawn = [one for cell in outputs for one in cell if "image/png" in one.get("data", {})]
    tables = [one for cell in outputs for one in cell if "text/html" in one.get("data", {})]
    assert len(drawn) >= 2
    assert len(tables) >= 2


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
