"""Windows has no terminals of the POSIX kind: nothing may need them before a pseudo-terminal is asked for."""

import ast
from pathlib import Path

import pytest

import drivers.ovens

POSIX_ONLY = {"termios", "tty", "pty", "fcntl", "pwd", "resource"}
FILES = [*sorted(Path(drivers.ovens.__file__).parent.rglob("*.py")), Path(__file__).with_name("served.py")]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_imports_nothing_posix_when_imported(path):
    imported = set()
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Import):
            imported |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            imported.add(node.module.split(".")[0])
    assert not imported & POSIX_ONLY


def test_all_files_are_looked_at():
    assert {"line", "line_settings", "served", "espec"} <= {path.stem for path in FILES}
