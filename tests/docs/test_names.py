"""Each class name stands once in the tree, and each package's docstring names everything in its folder."""

import ast
import importlib
import re
from collections import defaultdict
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FLOORS = ("analysis", "app", "drivers", "flexura", "simulation")
FILES = sorted(path for floor in FLOORS for path in (ROOT / floor).rglob("*.py"))
PACKAGES = sorted(path.parent for path in FILES if path.name == "__init__.py")


def name(path: Path) -> str:
    return str(path.relative_to(ROOT))


def test_a_class_name_stands_once() -> None:
    places = defaultdict(list)
    for path in FILES:
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                places[node.name].append(name(path))
    assert {cls: where for cls, where in places.items() if len(where) > 1} == {}


def test_array_aliases_and_progress_come_from_one_place() -> None:
    homes = {"analysis/arrays.py", "analysis/progress.py"}
    alias = re.compile(
        r"^\w+ = (?:NDArray\[np\.(?:float64|complex128|int_|bool_)\]|Callable\[\[str, float\], None\])$",
        re.MULTILINE,
    )
    others = [path for path in FILES if name(path) not in homes]
    again = {name(path): alias.findall(path.read_text(encoding="utf-8")) for path in others}
    assert {path: found for path, found in again.items() if found} == {}


@pytest.mark.parametrize("folder", PACKAGES, ids=name)
def test_a_packages_docstring_is_its_table_of_contents(folder: Path) -> None:
    inside = {path.stem for path in folder.glob("*.py")}
    inside |= {path.parent.name for path in folder.glob("*/__init__.py")}
    text = importlib.import_module(".".join(folder.relative_to(ROOT).parts)).__doc__ or ""
    named = set(re.findall(r"`(\w+)`", text))
    assert sorted(module for module in inside - named if not module.startswith("_")) == []
    rows = re.findall(r"^``(\w+)``  ", text, re.MULTILINE)
    assert sorted({row for row in rows if rows.count(row) > 1}) == []
