"""The two commands on a fresh machine: one installation, whatever happens to it, then the words are handed on."""

import configparser
import importlib.util
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[1]


class Killed(BaseException):
    """The machine goes down: nothing of ours may catch it."""


class FakeMachine:
    """Stands in for ``subprocess``: makes the environment's files, and notes what was run."""

    CalledProcessError = subprocess.CalledProcessError

    def __init__(self, python: Path) -> None:
        self.python = python
        self.makers: list[str] = []
        self.installs: list[list[str]] = []
        self.started: list[tuple[list[str], str | None]] = []
        self.dies: str | None = None
        self.fails = False
        self.brings: list[Path] = []
        self.imported_with: list[dict[str, str]] = []
        self.status = 0

    def run(self, command: list[str], **options: Any) -> SimpleNamespace:
        if command[1:3] == ["-m", "venv"]:
            self.makers.append(command[0])
            self.python.parent.mkdir(parents=True)
            self._may_die("venv")
            (self.python.parents[1] / "pyvenv.cfg").write_text("home = somewhere")
            self.python.write_text("")
        elif "install" in command:
            site = self.python.parents[1] / "lib"
            site.mkdir(exist_ok=True)
            (site / "half").write_text("x")
            for path in self.brings:
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text("x")
            self._may_die("pip")
            if self.fails:
                raise subprocess.CalledProcessError(1, command)
            self.installs.append(command)
        elif command[1] == "-c":
            compile(command[2], "everything", "exec")
            self.imported_with.append(options["env"])
        return SimpleNamespace(stdout="torch (2.13.0+cpu)")

    def _may_die(self, where: str) -> None:
        if self.dies == where:
            raise Killed

    def Popen(self, command: list[str], cwd: str | None) -> Any:
        self.started.append((command, cwd))
        return _Child(self.status)


class _Child:
    def __init__(self, status: int) -> None:
        self.status = status

    def __enter__(self) -> "_Child":
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def wait(self) -> int:
        return self.status


def load(root: Path, environment: Path | str | None, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.delenv("FLEXURA_VENV", raising=False)
    if environment:
        monkeypatch.setenv("FLEXURA_VENV", str(environment))
    specification = importlib.util.spec_from_file_location("start_under_test", root / "start.py")
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """Copy what start.py reads, to be changed at will."""
    root = tmp_path / "project"
    root.mkdir()
    for name in ("start.py", "setup.cfg", "constraints.txt"):
        shutil.copy(ROOT / name, root / name)
    return root


Call = Callable[..., int]


@pytest.fixture
def machine(project: Path) -> FakeMachine:
    name = "Scripts/python.exe" if os.name == "nt" else "bin/python"
    return FakeMachine(project / ".venv" / name)


@pytest.fixture
def call(project: Path, machine: FakeMachine, monkeypatch: pytest.MonkeyPatch) -> Call:
    """Run start.py anew, as each command does."""

    def run(*words: str) -> int:
        start = load(project, None, monkeypatch)
        monkeypatch.setattr(start, "subprocess", machine)
        monkeypatch.setattr(sys, "argv", ["start.py", *words])
        status: int = start.main()
        return status

    return run


def test_installs_once(call: Call, machine: FakeMachine, project: Path) -> None:
    call("demo")
    call("demo")
    assert len(machine.installs) == 1
    command = machine.installs[0]
    assert command[command.index("-c") + 1] == str(project / "constraints.txt")
    assert command[command.index("-e") + 1] == f"{project}[audio,drawings,meshes,onnx]"


def test_environment_is_made_by_a_python_that_is_not_its_own(call: Call, machine: FakeMachine) -> None:
    """`.venv/bin/python start.py` deletes the Python it runs in where pins have changed."""
    call("demo")
    assert machine.makers == [sys._base_executable]  # type: ignore[attr-defined]


def test_words_go_to_flexura_or_to_pytest(call: Call, machine: FakeMachine, project: Path) -> None:
    call("identify", "a b", "--json")
    call("tests", "-k", "frf", "--durations=3")
    call("tests", "setup.cfg::one")
    call()
    (verb, where), (tests, there), (one_file, _), (bare, _) = machine.started
    assert verb == [str(machine.python), "-P", "-m", "flexura", "identify", "a b", "--json"]
    assert where is None  # paths the user gives are relative to where the user stands
    assert tests[:3] == [str(machine.python), "-m", "pytest"]
    assert tests[-3:] == ["-k", "frf", "--durations=3"]
    assert "-n" in tests  # on several cores, which a few tests are not worth
    assert "-n" not in one_file
    assert there == str(project)
    assert bare[-2:] == ["-m", "flexura"]


@pytest.mark.parametrize(("word", "extra"), [("tests", "dev"), ("docs", "docs")])
def test_what_tests_and_documentation_need_is_installed_when_asked_for(
    call: Call, machine: FakeMachine, project: Path, word: str, extra: str
) -> None:
    call("demo")
    call(word)
    call(word)
    call("demo")
    first, added = machine.installs
    assert first[-1] == f"{project}[audio,drawings,meshes,onnx]"
    settings = configparser.ConfigParser(interpolation=None)
    settings.read(project / "setup.cfg", encoding="utf-8")
    assert set(settings["options.extras_require"][extra].split()) < set(added)
    assert added[added.index("-c") + 1] == str(project / "constraints.txt")


def test_killed_while_what_tests_need_is_added_leaves_the_program_as_it_is(
    call: Call, machine: FakeMachine
) -> None:
    """A project is taken out before it is installed anew, so it is not named."""
    call("demo")
    machine.dies = "pip"
    with pytest.raises(Killed):
        call("tests")
    machine.dies = None
    assert call("demo") == 0
    assert len(machine.installs) == 1
    call("tests")
    assert "-e" not in machine.installs[1]


def test_documentation_is_made_by_sphinx(call: Call, machine: FakeMachine, project: Path) -> None:
    call("docs", "--quiet")
    call("docs")
    (command, where), again = machine.started
    assert command[:3] == [str(machine.python), "-m", "sphinx"]
    assert {"--fail-on-warning", "--quiet"} < set(command)
    assert command[-2:] == [".", "site"]
    assert again[1] == where == str(project)


def test_documentation_is_installed_anew_with_the_environment(
    call: Call, machine: FakeMachine, project: Path
) -> None:
    call("docs")
    pins = project / "constraints.txt"
    pins.write_text(pins.read_text().replace("numpy==", "numpy==9."))
    call("docs")
    assert len(machine.installs) == 4


def test_status_of_the_verb_is_passed_on(call: Call, machine: FakeMachine) -> None:
    machine.status = 2
    assert call("import", "nowhere") == 2


@pytest.mark.parametrize("change", ["pin", "requirement", "extra", "entry"])
def test_changed_pins_install_anew(call: Call, machine: FakeMachine, project: Path, change: str) -> None:
    call("demo")
    name = "constraints.txt" if change == "pin" else "setup.cfg"
    old, new = {
        "pin": ("numpy==", "numpy==9."),
        "requirement": ("    pyuff\n", "    pyuff\n    another\n"),
        "extra": ("    ezdxf\n", "    ezdxf\n    another\n"),
        "entry": ("flexura.__main__:main", "flexura.__main__:another"),
    }[change]
    text = (project / name).read_text()
    assert old in text
    (project / name).write_text(text.replace(old, new, 1))
    call("demo")
    assert len(machine.installs) == 2


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("[mypy]\n", "[mypy]\npretty = true\n"),
        ("    app.view\n", "    app.view\n    app.more\n"),
        ("*.tdms", "*.wav"),
    ],
)
def test_linters_packages_and_data_do_not_install_anew(
    call: Call, machine: FakeMachine, project: Path, old: str, new: str
) -> None:
    """Packages and data are read where they stand."""
    call("demo")
    text = (project / "setup.cfg").read_text()
    assert old in text
    (project / "setup.cfg").write_text(text.replace(old, new, 1))
    call("demo")
    assert len(machine.installs) == 1


def test_what_the_checks_need_more_is_added_to_the_environment_that_is_there(
    call: Call, machine: FakeMachine, project: Path
) -> None:
    call("tests")
    text = (project / "setup.cfg").read_text()
    (project / "setup.cfg").write_text(text.replace("    mypy\n", "    mypy\n    another\n", 1))
    call("demo")
    call("tests")
    first, _, added = machine.installs
    assert "-e" in first
    assert "another" in added
    assert "-e" not in added


def test_parts_of_packages_that_nothing_reads_are_deleted(call: Call, machine: FakeMachine, project: Path) -> None:
    packages = project / ".venv" / ("Lib/site-packages" if os.name == "nt" else "lib/python3.11/site-packages")
    kept = [
        packages / name for name in ("torch/bin/torch_shm_manager", "torch/lib/libtorch.so", "mine/test/one.py")
    ]
    gone = [packages / name for name in ("torch/bin/protoc", "torch/bin/test_jit", "torch/include/a/b.h")]
    machine.brings = [*kept, *gone]
    call("demo")
    assert [path for path in (*kept, *gone) if path.exists()] == kept
    assert not (packages / "torch" / "include").exists()


def test_bytecode_is_kept_also_where_python_is_told_to_keep_none(
    call: Call, machine: FakeMachine, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")
    call("demo")
    (environment,) = machine.imported_with
    assert "PYTHONDONTWRITEBYTECODE" not in environment
    assert environment["PATH"] == os.environ["PATH"]


def test_what_cannot_be_deleted_stays_and_the_installation_stands(
    call: Call, machine: FakeMachine, project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A virus scanner holds files open on Windows; the space saved is not worth another installation."""
    packages = project / ".venv" / ("Lib/site-packages" if os.name == "nt" else "lib/python3.11/site-packages")
    held = [packages / name for name in ("torch/bin/protoc", "torch/include/a/b.h")]
    machine.brings = held

    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(13, "in use by another program")

    for name in ("unlink", "rmdir"):
        monkeypatch.setattr(os, name, refuse)
    call("demo")
    call("demo")
    assert all(path.exists() for path in held)
    assert len(machine.installs) == 1


@pytest.mark.parametrize("moment", ["venv", "pip"])
def test_killed_installation_is_made_anew(call: Call, machine: FakeMachine, project: Path, moment: str) -> None:
    machine.dies = moment
    with pytest.raises(Killed):
        call("demo")
    assert not machine.started
    machine.dies = None
    assert call("demo") == 0
    assert len(machine.installs) == 1
    assert len(machine.started) == 1


def test_torn_stamp_is_no_stamp(call: Call, machine: FakeMachine, project: Path) -> None:
    call("demo")
    stamp = project / ".venv" / "installed-pins.sha256"
    stamp.write_text(stamp.read_text()[:20])
    call("demo")
    assert len(machine.installs) == 2


def test_removal_killed_after_its_first_file_is_gone_on_with(
    call: Call, machine: FakeMachine, project: Path
) -> None:
    call("demo")
    (project / ".venv" / "pyvenv.cfg").unlink()
    (project / ".venv" / "installed-pins.sha256").unlink()
    assert call("demo") == 0
    assert len(machine.installs) == 2


def test_failed_installation_says_how_to_go_on(call: Call, machine: FakeMachine) -> None:
    machine.fails = True
    with pytest.raises(SystemExit, match="Run the same command again"):
        call("demo")
    machine.fails = False
    assert call("demo") == 0


def test_folder_of_somebody_else_is_not_deleted(
    project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "thesis.tex").write_text("years")
    start = load(project, mine, monkeypatch)
    monkeypatch.setattr(sys, "argv", ["start.py", "demo"])
    with pytest.raises(SystemExit, match=r"thesis\.tex"):
        start.main()
    assert (mine / "thesis.tex").read_text() == "years"


def test_environment_named_relatively_is_where_the_user_stands(
    project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    start = load(project, "elsewhere", monkeypatch)
    assert start.ENVIRONMENT.parent == tmp_path


def test_real_call_from_another_folder_with_an_app_of_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing fake: the environment these tests run in, if start.py made it, serves a real command."""
    environment = Path(sys.prefix)
    if not load(ROOT, environment, monkeypatch).ready():  # or the call below would tear it down to make it anew
        pytest.skip("these tests do not run in an environment that start.py finished for these pins")
    (tmp_path / "app").mkdir()
    (tmp_path / "app" / "__main__.py").write_text("raise SystemExit('the wrong app')")
    surroundings = os.environ | {"FLEXURA_VENV": str(environment)}
    done = subprocess.run(
        [sys._base_executable, str(ROOT / "start.py"), "--version"],  # type: ignore[attr-defined]
        cwd=tmp_path,
        env=surroundings,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("flexura, version")


def test_a_lean_environment_has_no_torch_and_serves_until_the_whole_one_is_asked_for(
    call: Call, machine: FakeMachine, project: Path
) -> None:
    call("--lean", "identify", "plate")
    call("--lean", "demo")
    packages, ours = machine.installs
    assert not [word for word in packages if word.startswith("torch")]
    settings = configparser.ConfigParser(interpolation=None)
    settings.read(project / "setup.cfg", encoding="utf-8")
    assert set(settings["options"]["install_requires"].split()) - set(packages) == {"torch==2.13.0"}
    assert {"onnx", "ezdxf"} < set(packages)  # of the extras that everybody gets
    assert ours[-3:] == ["--no-deps", "-e", str(project)]
    assert machine.started[0][0][-2:] == ["identify", "plate"]
    call("demo")
    assert "torch==2.13.0" in machine.installs[2]
    assert len(machine.makers) == 1  # nothing is installed twice
    call("--lean", "demo")
    call("demo")
    assert len(machine.installs) == 3


def test_a_lean_environment_is_made_anew_for_other_pins(call: Call, machine: FakeMachine, project: Path) -> None:
    call("--lean", "demo")
    with (project / "constraints.txt").open("a", encoding="utf-8") as pins:
        pins.write("another==1.0\n")
    call("--lean", "demo")
    assert len(machine.makers) == 2


def test_tests_run_in_a_lean_environment(call: Call, machine: FakeMachine) -> None:
    call("--lean", "tests")
    call("--lean", "tests")
    assert len(machine.installs) == 3
    assert "pytest" in machine.installs[2]
