"""Functions have at most 60 lines without their docstrings; a file of over 500 holds more than one concept."""

import ast
from collections.abc import Callable
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
FLOORS = ("analysis", "app", "drivers", "flexura", "simulation")
FILES = sorted(path for floor in FLOORS for path in (ROOT / floor).rglob("*.py"))
LINES, FUNCTION_LINES = 500, 60


def name(path: Path) -> str:
    return str(path.relative_to(ROOT))


def lines_of(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Lines of a function from its ``def`` on, less those of its docstring."""
    text = function.body[0] if ast.get_docstring(function) is not None else None
    told = text.end_lineno - text.lineno + 1 if text is not None and text.end_lineno else 0
    assert function.end_lineno is not None
    return function.end_lineno - function.lineno + 1 - told


def long_files() -> dict[str, int]:
    counts = {name(path): path.read_text(encoding="utf-8").count("\n") for path in FILES}
    return {path: count for path, count in counts.items() if count > LINES}


def long_functions() -> dict[str, int]:
    return {
        f"{name(path)}:{node.name}": lines_of(node)
        for path in FILES
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and lines_of(node) > FUNCTION_LINES
    }


@pytest.mark.parametrize("found", [long_files, long_functions])
def test_nothing_is_too_long(found: Callable[[], dict[str, int]]) -> None:
    assert found() == {}
