"""Functions of the library write files where ``out`` names a folder, and nowhere else."""

import inspect
from pathlib import Path

import numpy as np
import pytest

import flexura
from tests.app.test_focus_compensate import panel, run  # noqa: F401

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "pp-plate"
WRITING = {"export_filters", "export_sweeps", "render", "report", "run"}
"""Those whose purpose is a file."""


def files(*folders: Path) -> dict[Path, int]:
    return {path: path.stat().st_mtime_ns for folder in folders for path in folder.rglob("*")}


def test_every_function_says_that_it_writes_only_where_out_is_given() -> None:
    told = {name for name in flexura.__all__ if "out" in inspect.signature(getattr(flexura, name)).parameters}
    assert told >= WRITING
    for name in told - WRITING:
        said = " ".join((inspect.getdoc(getattr(flexura, name)) or "").split())
        assert "othing is written where it is left out." in said, name
        assert inspect.signature(getattr(flexura, name)).parameters["out"].default is None, name
    page = (EXAMPLE.parents[1] / "docs" / "guide" / "library.md").read_text(encoding="utf-8")
    assert all(f"`{name}`" in page.split("\n\n```python")[0] for name in WRITING)


def test_without_out_nothing_is_written(
    run: Path,  # noqa: F811
    panel: Path,  # noqa: F811
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    soundfile = pytest.importorskip("soundfile")
    sound = tmp_path / "noise.wav"
    soundfile.write(sound, 0.1 * np.random.default_rng(4).standard_normal(16_000), 4_000, subtype="DOUBLE")
    here = tmp_path / "here"
    here.mkdir()
    monkeypatch.chdir(here)
    flexura.focus(run, panel, out=run)
    before = files(tmp_path, EXAMPLE)
    calls = {
        "frf": lambda: flexura.frf(EXAMPLE),
        "identify": lambda: flexura.identify(EXAMPLE, band=(150.0, 230.0)),
        "focus": lambda: flexura.focus(run, panel, temperature=20.0),
        "compensate": lambda: flexura.compensate(run, panel),
        "radiation": lambda: flexura.radiation(run),
        "study": lambda: flexura.study(4, run, panel=panel),
        "thermometer": lambda: flexura.thermometer(run, simulate=sound, temperature=20.3, seed=1),
        "plot": lambda: flexura.plot(flexura.frf(EXAMPLE)),
    }
    for name, call in calls.items():
        found = call()
        assert repr(found), name
        assert "None" not in repr(found).splitlines()[0], name
        assert files(tmp_path, EXAMPLE) == before, name
        if hasattr(found, "file"):
            assert found.file is None, name
    assert flexura.thermometer(run, simulate=sound, temperature=20.3, seed=1).record()["file"] is None
