"""What docstrings say is true: a Parameters section names parameters that exist, and gives the shape of arrays."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FLOORS = ("analysis", "app", "drivers", "flexura", "simulation")

Function = ast.FunctionDef | ast.AsyncFunctionDef


def functions(tree: ast.AST, before: str = "") -> Iterator[tuple[str, Function]]:
    """Functions and methods, with their names inside the module."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.ClassDef | Function):
            yield from functions(node, f"{before}{node.name}.")
        if isinstance(node, Function):
            yield f"{before}{node.name}", node


def parameters(function: Function) -> dict[str, str]:
    """Annotation of every parameter, by name."""
    every = function.args
    declared = [*every.posonlyargs, *every.args, *every.kwonlyargs, every.vararg, every.kwarg]
    return {a.arg: ast.unparse(a.annotation) if a.annotation else "" for a in declared if a is not None}


def described(text: str) -> dict[str, str]:
    """Heading of every entry in the section Parameters of a docstring in numpy's style, by name."""
    section = re.search(r"^Parameters\n-+\n(.*?)(?=^\w[\w ]*\n-+$|\Z)", text, re.MULTILINE | re.DOTALL)
    headings = re.findall(r"^\S.*$", section.group(1), re.MULTILINE) if section else []
    return {name.strip(" *"): line for line in headings for name in line.partition(":")[0].split(",")}


def is_array(annotation: str) -> bool:
    return bool(re.fullmatch(r"(?:Real|Complex|Whole|Mask|Numbers|NDArray\[.*\])(?: \| None)?", annotation))


def untrue(function: Function) -> list[str]:
    """Entries that name no parameter, and arrays without a shape."""
    has, told = parameters(function), described(ast.get_docstring(function) or "")
    strangers = [name for name in told if name not in has]
    shapeless = [
        f"shape of {name}" for name, line in told.items() if is_array(has.get(name, "")) and "(" not in line
    ]
    return strangers + shapeless


def test_parameters_described_exist_and_arrays_have_shapes() -> None:
    found = {
        f"{path.relative_to(ROOT)}:{name}": untrue(function)
        for floor in FLOORS
        for path in sorted((ROOT / floor).rglob("*.py"))
        for name, function in functions(ast.parse(path.read_text(encoding="utf-8")))
    }
    assert {where: what for where, what in found.items() if what} == {}


@pytest.mark.parametrize(
    ("entry", "what"), [("x : (N,) ndarray, m", []), ("x : ndarray", ["shape of x"]), ("y : (N,) ndarray", ["y"])]
)
def test_an_untrue_entry_is_seen(entry: str, what: list[str]) -> None:
    (node,) = ast.parse(
        f'def f(x: Real):\n    """Sum.\n\n    Parameters\n    ----------\n    {entry}\n    """'
    ).body
    assert isinstance(node, ast.FunctionDef)
    assert untrue(node) == what
