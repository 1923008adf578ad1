"""setup.cfg, constraints.txt, docs/dependencies.md and the imports tell one story."""

import ast
import configparser
import re
import sys
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
FLOORS = ("analysis", "app", "drivers", "flexura", "simulation")
PARTS_OF_PYDANTIC = {"annotated-types", "pydantic-core"}


def plain(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def asked_for() -> dict[str, set[str]]:
    settings = configparser.ConfigParser(interpolation=None)
    settings.read(ROOT / "setup.cfg", encoding="utf-8")
    lists = {
        "run": settings["options"]["install_requires"],
        "bench": settings["options.extras_require"]["bench"],
        "audio": settings["options.extras_require"]["audio"],
        "drawings": settings["options.extras_require"]["drawings"],
        "meshes": settings["options.extras_require"]["meshes"],
        "cluster": settings["options.extras_require"]["cluster"],
        "slurm": settings["options.extras_require"]["slurm"],
        "docs": settings["options.extras_require"]["docs"],
        "notebooks": settings["options.extras_require"]["notebooks"],
        "notify": settings["options.extras_require"]["notify"],
        "onnx": settings["options.extras_require"]["onnx"],
        "soundcard": settings["options.extras_require"]["soundcard"],
        "tables": settings["options.extras_require"]["tables"],
        "mdf": settings["options.extras_require"]["mdf"],
        "dev": settings["options.extras_require"]["dev"],
    }
    return {
        what: {plain(re.split(r"[=<>!\[; ]", line)[0]) for line in text.split("\n") if line}
        for what, text in lists.items()
    }


def pinned() -> set[str]:
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    return {plain(line.split("==")[0]) for line in lines if "==" in line}


def explained() -> set[str]:
    rows = re.findall(
        r"^\| `([^`]+)` \|", (ROOT / "docs/dependencies.md").read_text(encoding="utf-8"), re.MULTILINE
    )
    return {plain(row) for row in rows}


def imported() -> set[str]:
    """Distributions that our packages import."""
    modules = set()
    for floor in FLOORS:
        for path in (ROOT / floor).rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Import):
                    modules |= {alias.name.split(".")[0] for alias in node.names}
                elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                    modules.add(node.module.split(".")[0])
    outside = modules - set(sys.stdlib_module_names) - set(FLOORS)
    known = packages_distributions()
    return {plain(known[module][0]) for module in outside}


def test_every_package_asked_for_is_pinned() -> None:
    wanted = asked_for()
    assert sorted(set().union(*wanted.values()) - pinned()) == []


def test_every_package_asked_for_is_explained_and_no_other() -> None:
    wanted = asked_for()
    assert explained() == set().union(*wanted.values())


def test_every_package_imported_is_asked_for() -> None:
    wanted = asked_for()
    installed = wanted["run"].union(*(wanted[extra] for extra in ("audio", "drawings", "meshes", "onnx")))
    assert sorted(imported() - PARTS_OF_PYDANTIC - installed) == []


@pytest.mark.parametrize("line", (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines())
def test_every_pin_is_exact_and_free_of_a_site(line: str) -> None:
    assert line.startswith("#") or re.fullmatch(r"[A-Za-z0-9_.-]+==[0-9][0-9A-Za-z.]*", line)
