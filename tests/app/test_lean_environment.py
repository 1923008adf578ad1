"""Without torch, as `start.py --lean` installs: nothing on the processor asks for it; --device says what to do."""

import ast
import sys
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import pytest

from app.files import provenance as made
from app.files.bad_file import ResultFileError
from app.stages.panel.inputs import checked_device

ROOT = Path(__file__).resolve().parents[2]
FLOORS = ("analysis", "app", "drivers", "flexura", "simulation")
OTHER_DEVICES = {"analysis/compensation/linearised.py", "app/stages/panel/inputs.py"}
"""Modules that import it, within functions, for devices other than the processor."""


def test_only_other_devices_import_torch() -> None:
    found = set()
    for path in (one for floor in FLOORS for one in (ROOT / floor).rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        names = {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
        names |= {str(node.module) for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
        if any(name.partition(".")[0] == "torch" for name in names):
            found.add(path.relative_to(ROOT).as_posix())
            assert not [
                node for node in tree.body if isinstance(node, ast.Import) and "torch" in ast.unparse(node)
            ]
    assert found == OTHER_DEVICES


def test_a_device_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "torch", None)
    checked_device("cpu")
    with pytest.raises(ResultFileError, match=r"--device cuda: torch is not installed.* python3 start.py"):
        checked_device("cuda")


def test_results_name_the_packages_that_are_there(monkeypatch: pytest.MonkeyPatch) -> None:
    def without(name: str) -> str:
        if name == "torch":
            raise PackageNotFoundError(name)
        return version(name)

    monkeypatch.setattr(made, "version", without)
    packages = made.provenance({})["packages"]
    assert set(packages) == {"numpy", "scipy", "h5py", "scikit-fem"}
