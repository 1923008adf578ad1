"""Mutation testing of the core modules: make the code wrong in one place, and see that a test fails.

    python -m tests.mutants h1                        25 mutants of H1, drawn with seed 0
    python -m tests.mutants poles --most 60 --seed 3  60 others of the pole fit
    python -m tests.mutants taps --lines analysis/focusing/fir.py:83     all of one line, or of several

Prints a line for each mutant, whether a test noticed it or it SURVIVED; exit status 1 if one did. The sources on
the disk are not changed: a forked process imports the mutated module from memory, runs the tests of its row in
`CORE`, and ends at the first that fails. One mutant at a time. Needs `os.fork`.
"""

import argparse
import ast
import contextlib
import copy
import importlib
import json
import os
import random
import signal
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.machinery import ModuleSpec, SourceFileLoader
from importlib.util import spec_from_file_location
from pathlib import Path
from tempfile import TemporaryDirectory
from types import CodeType

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES_OF_OTHERS = ("numpy", "scipy", "pydantic", "pydantic_core", "_pytest", "h5py")
"""That take long to import; nothing of ours may be imported before a mutant is."""
PLAIN = ("-x", "-q", "-p", "no:xdist", "-p", "no:cacheprovider", "-o", "python_files=test_*.py")
"""The last because pytest imports what looks like a test by itself, and ``score_test.py`` does."""
CORE: dict[str, tuple[Sequence[str], Sequence[str]]] = {
    "h1": (
        ("analysis/recordings/h1.py", "analysis/recordings/noise_power.py"),
        tuple(f"analysis/recordings/test_{name}.py" for name in ("noise_power", "sweep_h1", "frf")),
    ),
    "poles": (
        ("analysis/identification/pole_search.py",),
        tuple(
            f"analysis/identification/test_{name}.py"
            for name in ("variable_projection", "pole_products", "normal_equations", "order")
        ),
    ),
    "updating": (
        ("analysis/updating/normal_equations.py",),
        tuple(f"analysis/updating/test_{name}.py" for name in ("normal_equations", "sweep_fit", "start")),
    ),
    "score": (("analysis/gap/search/score_test.py",), ("analysis/gap/search/test_score_test.py",)),
    "taps": (
        ("analysis/focusing/fir.py", "analysis/focusing/design.py"),
        ("analysis/focusing/test_fir.py", "analysis/focusing/test_field_fir.py"),
    ),
    "rest": (
        ("drivers/watchdog/guard.py", "drivers/watchdog/supervision.py"),
        (
            "drivers/watchdog/test_guard.py",
            "drivers/watchdog/test_rest_watch.py",
            "drivers/rig/test_supervision.py",
        ),
    ),
}
"""Files of a core module, and the fast tests that are to notice."""

OTHER_OPERATOR: dict[type[ast.AST], tuple[type[ast.AST], ...]] = {
    ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
    ast.Add: (ast.Sub,),
    ast.Sub: (ast.Add,),
    ast.Mult: (ast.Div,),
    ast.Div: (ast.Mult,),
    ast.Pow: (ast.Mult,),
    ast.And: (ast.Or,),
    ast.Or: (ast.And,),
}
SECONDS_BEYOND, TIMES_BEYOND = 20.0, 4.0
"""Processor time allowed: so many times what all tests take unchanged, and so many seconds more (an import)."""
NOT_IMPORTED = 71
"""Exit status of a process in which the mutant was not imported."""
WALL_FACTOR = 5.0
"""Wall time allowed, over processor time: a mutant may wait for ever, and the machine may be busy."""


@dataclass(frozen=True)
class Mutant:
    """One change of one file.

    Attributes
    ----------
    path : Path
    line : int
        From 1.
    change : str
        Code before and after it.
    tree : ast.Module
        The changed file.
    """

    path: Path
    line: int
    change: str
    tree: ast.Module

    @property
    def place(self) -> str:
        """File and line."""
        return f"{self.path.relative_to(ROOT)}:{self.line}"


def mutants(path: Path) -> Iterator[Mutant]:
    """Every mutant of a file: comparisons and operators swapped, numbers and conditions changed, None returned.

    Texts, annotations, messages of errors and imports stay as they are: no test is to depend on them.
    """
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in list(_changeable(tree)):
        before = _first_line(node)
        for name, value in _changes(node):
            kept = getattr(node, name)
            setattr(node, name, value)
            yield Mutant(path, node.lineno, f"{before}  ->  {_first_line(node)}", copy.deepcopy(tree))
            setattr(node, name, kept)


def _first_line(node: ast.AST) -> str:
    return ast.unparse(node).partition("\n")[0]


def _changeable(node: ast.AST) -> Iterator[ast.AST]:
    """Nodes below one, without those in annotations, texts, raises and imports."""
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST) and not isinstance(child, ast.Raise | ast.JoinedStr | ast.Import):
                yield child
                yield from _changeable(child)


def _changes(node: ast.AST) -> Iterator[tuple[str, object]]:
    """Fields of a node, and other values for them."""
    match node:
        case ast.Compare(ops=[operator]):
            yield from (("ops", [other()]) for other in OTHER_OPERATOR[type(operator)])
        case ast.BinOp(op=operator) | ast.BoolOp(op=operator) | ast.AugAssign(op=operator):
            yield from (("op", other()) for other in OTHER_OPERATOR.get(type(operator), ()))
        case ast.Constant(value=bool(value)):
            yield "value", not value
        case ast.Constant(value=int(value)):
            yield "value", value + 1
        case ast.Constant(value=float(value)):
            yield "value", 2.0 * value if value else 1.0
        case ast.UnaryOp(op=ast.USub(), operand=ast.Name() | ast.BinOp() | ast.Call()):
            yield "op", ast.UAdd()
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            yield "operand", ast.UnaryOp(ast.Not(), operand, lineno=node.lineno, col_offset=node.col_offset)
        case ast.If(test=test) | ast.IfExp(test=test) if not isinstance(test, ast.Compare):
            yield "test", ast.UnaryOp(ast.Not(), test, lineno=node.lineno, col_offset=node.col_offset)
        case ast.Return(value=ast.expr(lineno=line, col_offset=place)):
            yield "value", ast.Constant(None, lineno=line, col_offset=place)


class _Changed(SourceFileLoader):
    """Imports one file as changed, and finds it before all other finders do."""

    def __init__(self, mutant: Mutant) -> None:
        self.module = ".".join(mutant.path.relative_to(ROOT).with_suffix("").parts)
        super().__init__(self.module, str(mutant.path))
        self._code = compile(mutant.tree, str(mutant.path), "exec", dont_inherit=True)
        self.imported = False

    def get_code(self, fullname: str) -> CodeType:
        """Return the changed code, never that of the cache."""
        self.imported = True
        return self._code

    def find_spec(self, fullname: str, path: object = None, target: object = None) -> ModuleSpec | None:
        """Return it for this module alone."""
        return spec_from_file_location(fullname, self.path, loader=self) if fullname == self.module else None


class _QuickestFirst:
    """Keeps how long each test took, and runs the quickest of a file first; files in their order of `CORE`."""

    def __init__(self, seconds: Mapping[str, float]) -> None:
        self.seconds = dict(seconds)

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Sort."""
        files = list(dict.fromkeys(item.path for item in items))
        items.sort(key=lambda item: (files.index(item.path), self.seconds.get(item.nodeid, 0.0)))

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Add."""
        self.seconds[report.nodeid] = self.seconds.get(report.nodeid, 0.0) + report.duration


def survives(mutant: Mutant, tests: Sequence[str], order: Mapping[str, float], seconds: float) -> bool:
    """Whether all tests pass with a mutant, in a process of its own.

    Parameters
    ----------
    tests : sequence of str
        Files.
    order : mapping
        Seconds of each test.
    seconds : float
        Processor time from which it counts as noticed: it does not end.

    Raises
    ------
    ValueError
        Where no test imports the file: nothing is known of the mutant then.
    """

    def run() -> int:
        import resource  # which Windows has not

        os.setsid()
        resource.setrlimit(resource.RLIMIT_CPU, (int(seconds), int(seconds) + 5))
        silent = os.open(os.devnull, os.O_WRONLY)
        os.dup2(silent, 1)
        os.dup2(silent, 2)
        changed = _Changed(mutant)
        sys.meta_path.insert(0, changed)  # type: ignore[arg-type]
        status = int(pytest.main([*PLAIN, *tests], plugins=[_QuickestFirst(order)]))
        return status if changed.imported else NOT_IMPORTED

    child = _forked(run)
    ends = time.monotonic() + WALL_FACTOR * seconds
    while time.monotonic() < ends:
        process, status = os.waitpid(child, os.WNOHANG)
        if process and os.waitstatus_to_exitcode(status) == NOT_IMPORTED:
            raise ValueError(f"{mutant.path}: no test in {', '.join(tests)} imports it")
        if process:
            return status == 0
        time.sleep(0.02)
    os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return False


def unchanged(tests: Sequence[str]) -> tuple[float, dict[str, float]]:
    """Run the tests as they are; return their processor time and the seconds of each.

    Whatever they import of other projects is imported here, too, so that no mutant has to import it again.
    """
    with TemporaryDirectory() as folder:
        kept = Path(folder) / "kept.json"

        def run() -> int:
            order, begun = _QuickestFirst({}), time.process_time()
            status = int(pytest.main([*PLAIN, *tests], plugins=[order]))
            foreign = [name for name in sys.modules if name.partition(".")[0] in PACKAGES_OF_OTHERS]
            kept.write_text(json.dumps([time.process_time() - begun, order.seconds, foreign]), encoding="utf-8")
            return status

        if os.waitpid(_forked(run), 0)[1] != 0:
            raise SystemExit("the tests fail without any mutant: mend them first")
        seconds, each, foreign = json.loads(kept.read_text(encoding="utf-8"))
    for name in foreign:
        with contextlib.suppress(ImportError):
            importlib.import_module(name)
    return seconds, each


def _forked(run: Callable[[], int]) -> int:
    """Process that ends with what `run` returns; 70 where it raises."""
    child = os.fork()
    if child == 0:
        status = 70
        try:
            status = run()
        finally:
            os._exit(status)
    return child


def main() -> int:
    """Run it; 0 where no mutant survived."""
    words = argparse.ArgumentParser(prog="python -m tests.mutants", description=(__doc__ or "").split("\n")[0])
    words.add_argument("module", choices=CORE)
    words.add_argument("--most", type=int, default=25, help="mutants, drawn at random (default: %(default)s)")
    words.add_argument("--seed", type=int, default=0, help="of the draw (default: %(default)s)")
    words.add_argument("--lines", nargs="+", metavar="FILE:LINE", help="whose mutants are tried, all of them")
    asked = words.parse_args()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # a fork has no threads of the library
    files, tests = CORE[asked.module]
    tests = [f"tests/{name}" for name in tests]
    every = [one for file in files for one in mutants(ROOT / file)]
    drawn = sorted(random.Random(asked.seed).sample(range(len(every)), min(asked.most, len(every))))  # noqa: S311
    chosen = [every[n] for n in drawn]
    if asked.lines:
        chosen = [one for one in every if one.place in asked.lines]
    seconds, order = unchanged(tests)
    survived = 0
    for number, mutant in enumerate(chosen, 1):
        lives = survives(mutant, tests, order, SECONDS_BEYOND + TIMES_BEYOND * seconds)
        survived += lives
        outcome = "SURVIVED" if lives else "noticed"
        print(f"{number}/{len(chosen)} {outcome:<8} {mutant.place}: {mutant.change}", flush=True)
    print(f"{asked.module}: {len(chosen)} of {len(every)} mutants, {len(chosen) - survived} noticed")
    return 1 if survived else 0


if __name__ == "__main__":
    sys.exit(main())
