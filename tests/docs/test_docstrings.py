"""Public functions with three or more parameters say what they take, give and refuse, with shapes and units."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FLOORS = ("analysis", "app", "drivers", "flexura", "simulation")

Function = ast.FunctionDef | ast.AsyncFunctionDef


def public(tree: ast.AST, before: str = "") -> Iterator[tuple[str, Function]]:
    """Functions and methods that others call, with their names inside the module."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            yield from public(node, f"{before}{node.name}.")
        elif isinstance(node, Function) and not node.name.startswith("_"):
            yield f"{before}{node.name}", node


def parameters(function: Function) -> list[ast.arg]:
    every = function.args
    return [a for a in (*every.posonlyargs, *every.args, *every.kwonlyargs) if a.arg not in ("self", "cls")]


def section(text: str, title: str) -> str:
    """Body of a section in numpy's style; empty where it is not there."""
    found = re.search(rf"^{title}\n-+\n(.*?)(?=^\w[\w ]*\n-+$|\Z)", text, re.MULTILINE | re.DOTALL)
    return found.group(1) if found else ""


def lacks(function: Function) -> list[str]:
    """Return what a docstring lacks: parameters, shapes of arrays, what is returned, what is raised."""
    text = ast.get_docstring(function) or ""
    told = section(text, "Parameters")
    names = {n.strip() for line in re.findall(r"^([\w, ]+?) *:", told, re.MULTILINE) for n in line.split(",")}
    names |= {line.strip() for line in re.findall(r"^(\w+)$", told, re.MULTILINE)}
    missing = [a.arg for a in parameters(function) if a.arg not in names]
    arrays = {a.arg for a in parameters(function) if a.annotation and is_array(a.annotation)}
    for name in sorted(arrays & names):
        line = next((part for part in told.splitlines() if re.match(rf"(?:[\w, ]+, )?{name}\b", part)), "")
        if "(" not in line:
            missing.append(f"shape of {name}")
    gives = function.returns is not None and ast.unparse(function.returns) not in ("None", "Self")
    if gives and not section(text, "Returns") and not section(text, "Yields"):
        missing.append("Returns")
    raises = any(isinstance(node, ast.Raise) and node.exc is not None for node in ast.walk(function))
    if raises and not section(text, "Raises"):
        missing.append("Raises")
    return missing


def is_array(annotation: ast.expr) -> bool:
    return bool(
        re.fullmatch(r"(?:Real|Complex|Whole|Mask|Numbers|NDArray\[.*\])(?: \| None)?", ast.unparse(annotation))
    )


def short() -> set[str]:
    found = set()
    for floor in FLOORS:
        for path in sorted((ROOT / floor).rglob("*.py")):
            module = ".".join(path.relative_to(ROOT).with_suffix("").parts)
            for name, function in public(ast.parse(path.read_text(encoding="utf-8"))):
                decorated = {ast.unparse(d).split("(")[0] for d in function.decorator_list}
                if decorated & {"click.command", "overload", "field_validator", "override"}:
                    continue
                if len(parameters(function)) >= 3 and lacks(function):
                    found.add(f"{module}.{name}")
    return found


def test_docstrings_say_what_goes_in_and_comes_out() -> None:
    assert sorted(short()) == []
