"""The mutants of a short text, and a test that notices one of them and not the other."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests import mutants

SOURCE = '''"""Text with 3 numbers."""

MOST = 4


def inside(x: float, most: int = 3, shown: bool = True) -> bool:
    """Whether 2 < 3."""
    if not shown:
        raise ValueError(f"{x + 1}")
    return 0.0 <= x < most + 1.5 or -x == 0
'''


def changes(text: str, folder: Path) -> list[str]:
    path = folder / "some.py"
    path.write_text(text, encoding="utf-8")
    return [one.change for one in mutants.mutants(path)]


def test_operators_numbers_conditions_and_answers_are_changed_and_texts_are_not(tmp_path: Path) -> None:
    found = changes(SOURCE, tmp_path)
    assert "4  ->  5" in found
    assert "3  ->  4" in found
    assert "True  ->  False" in found
    assert "1.5  ->  3.0" in found
    assert "0.0  ->  1.0" in found
    assert "most + 1.5  ->  most - 1.5" in found
    assert "-x == 0  ->  -x != 0" in found
    assert "-x  ->  +x" in found
    assert "not shown  ->  not not shown" in found
    assert any(one.endswith("->  return None") for one in found)
    assert any(" or " in one.partition("->")[0] and " and " in one.partition("->")[2] for one in found)
    assert not any("x + 1" in one for one in found)  # of a message
    assert len(found) == len(set(found))


def test_each_is_one_change_of_code_that_compiles(tmp_path: Path) -> None:
    path = tmp_path / "some.py"
    path.write_text("def less(a, b):\n    return a < b\n", encoding="utf-8")
    answers = set()
    for one in mutants.mutants(path):
        space: dict[str, object] = {}
        exec(compile(one.tree, "some.py", "exec"), space)  # noqa: S102 (the text above, changed)
        less = space["less"]
        answers.add(tuple(less(a, 1) for a in (0, 1, 2)))  # type: ignore[operator]
    assert answers == {(True, True, False), (False, True, True), (None, None, None)}


@pytest.mark.parametrize("module", mutants.CORE)
def test_every_core_module_and_its_tests_are_there(module: str) -> None:
    files, tests = mutants.CORE[module]
    for name in (*files, *(f"tests/{test}" for test in tests)):
        assert (mutants.ROOT / name).is_file(), name


CHILD = """
import sys
from tests import mutants
path = mutants.ROOT / "drivers" / "watchdog" / "guard.py"
swapped = next(one for one in mutants.mutants(path) if "event is not E.COMMAND" in one.change)
for test in ("drivers/watchdog/test_guard.py", "drivers/watchdog/test_rest_watch.py", "analysis/test_phase.py"):
    print(mutants.survives(swapped, [f"tests/{test}"], {}, 60.0), flush=True)
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="a mutant lives in a forked process")
def test_a_mutant_is_noticed_by_a_test_of_what_it_changes_and_by_no_other() -> None:
    path = mutants.ROOT / "drivers" / "watchdog" / "guard.py"
    before = path.read_bytes()
    done = subprocess.run([sys.executable, "-c", CHILD], cwd=mutants.ROOT, capture_output=True, text=True)
    assert done.stdout.split() == ["False", "True"], done.stderr
    assert "no test in tests/analysis/test_phase.py imports it" in done.stderr
    assert path.read_bytes() == before
