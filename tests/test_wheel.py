"""What ``pip install`` of the wheel gives: every package, the examples, and a flexura that works."""

import configparser
import os
import shutil
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("analysis", "app", "drivers", "flexura", "simulation")
SCRIPT = """
import flexura, app, tests
from app.files.shipped import shipped
print(app.__file__, shipped("pp-plate"), tests.__file__, flexura.load(shipped("pp-plate")), sep="\\n")
"""


def settings() -> configparser.ConfigParser:
    found = configparser.ConfigParser(interpolation=None)
    found.read(ROOT / "setup.cfg", encoding="utf-8")
    return found


def test_every_package_is_in_the_wheel() -> None:
    made = [file.parent.relative_to(ROOT) for name in PACKAGES for file in (ROOT / name).rglob("__init__.py")]
    there = {".".join(folder.parts) for folder in made}
    assert set(settings()["options"]["packages"].split()) == there


def test_types_and_forms_are_in_the_wheel() -> None:
    """Beside Python's files: marks by which type checkers read our types in users' scripts, and the C forms."""
    patterns = settings()["options.package_data"]
    others = [
        path.relative_to(ROOT)
        for name in PACKAGES
        for path in (ROOT / name).rglob("*")
        if path.is_file() and path.suffix not in (".py", ".pyc")
    ]
    assert {Path(name) / "py.typed" for name in PACKAGES} < set(others)
    for path in others:
        wanted = [*patterns["*"].split(), *patterns.get(".".join(path.parent.parts), "").split()]
        assert any(path.match(pattern) for pattern in wanted), path


def test_every_example_a_verb_starts_from_is_in_the_wheel() -> None:
    patterns = [pattern for listed in settings()["options.data_files"].values() for pattern in listed.split()]
    shipped = {path for pattern in patterns for path in ROOT.glob(pattern)}
    wanted = {
        path for path in (ROOT / "examples").rglob("*") if "__pycache__" not in path.parts and path.name[0] != "."
    }
    assert {path for path in wanted if path.is_file()} == {path for path in shipped if path.is_file()}


@pytest.mark.slow
def test_the_wheel_gives_a_working_flexura(tmp_path: Path) -> None:
    """Built from a copy, used beside foreign packages of our names; dependencies are lent by a path file."""
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet"]
    source, wheels, environment = tmp_path / "source", tmp_path / "wheels", tmp_path / "environment"
    shutil.copytree(
        ROOT, source, ignore=shutil.ignore_patterns(".*", "*-campaign", "*-run", "runs", "flexura-demo")
    )
    subprocess.run(
        [*pip, "wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", str(wheels), str(source)], check=True
    )
    (wheel,) = wheels.glob("flexura-*.whl")
    venv.create(environment, with_pip=False)
    scripts = environment / ("Scripts" if os.name == "nt" else "bin")
    python = scripts / ("python.exe" if os.name == "nt" else "python")
    subprocess.run([*pip, "--python", str(python), "install", "--no-deps", "--no-index", str(wheel)], check=True)
    site = subprocess.run(
        [python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"],
        capture_output=True,
        text=True,
        check=True,
    )
    (Path(site.stdout.strip()) / "lent.pth").write_text(sysconfig.get_path("purelib"), encoding="utf-8")

    desk = tmp_path / "desk"
    for name in (*PACKAGES[:2], "tests"):  # whose packages have the names of ours
        (desk / name).mkdir(parents=True)
        (desk / name / "__init__.py").write_text("raise RuntimeError('the wrong one')" * (name != "tests"))
    surroundings = os.environ | {"PYTHONPATH": str(desk)}

    def run(*words: str | Path) -> subprocess.CompletedProcess[str]:
        return subprocess.run(words, cwd=desk, env=surroundings, capture_output=True, text=True, check=True)

    assert "acquire" in run(scripts / "flexura", "--help").stdout
    (desk / "script.py").write_text(SCRIPT)
    told = run(python, "script.py").stdout.splitlines()
    package, example, own = map(Path, told[:3])
    assert environment in package.parents
    assert environment in example.parents
    assert own == desk / "tests" / "__init__.py"
    assert told[3] == "<Campaign 'pp-plate': 16 sweeps, 0.0 to 60.0 °C, sensors S1>"
    imported = run(scripts / "flexura", "import", str(example), "--out", "plate").stderr
    assert "16 sweeps, 0 to 60 °C, imported into" in imported
    assert (desk / "plate" / "protocol.json").is_file()
