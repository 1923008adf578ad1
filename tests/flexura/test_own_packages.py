"""Scripts beside packages of the same names as ours: ours are found, or the reason is told."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
NAMES = ("analysis", "app", "drivers", "simulation")


@pytest.fixture
def desk(tmp_path: Path) -> Path:
    """Make a folder with packages of our names, and of the usual name of tests."""
    for name in (*NAMES, "tests"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text(f"FOREIGN = '{name}'\n")
    (tmp_path / "app" / "models.py").write_text("")
    return tmp_path


def run(desk: Path, *words: str, inherited: str = str(ROOT)) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"PYTHONPATH": inherited}
    return subprocess.run(
        [sys.executable, *words], cwd=desk, env=environment, capture_output=True, text=True, check=False
    )


def script(desk: Path, text: str) -> subprocess.CompletedProcess[str]:
    (desk / "script.py").write_text(text)
    return run(desk, "script.py")


def test_a_script_beside_foreign_packages_gets_ours_and_its_own_tests(desk: Path) -> None:
    done = script(
        desk,
        "import flexura, tests, analysis.recordings.frf, app.stages.identify, drivers.rig, simulation.twin\n"
        "ours = (analysis, app, drivers, simulation)\n"
        "print(tests.FOREIGN, flexura.load.__module__, *(package.__file__ for package in ours))",
    )
    assert done.returncode == 0, done.stderr
    own, load, *files = done.stdout.split()
    assert (own, load) == ("tests", "flexura.campaigns")
    assert files == [str(ROOT / name / "__init__.py") for name in NAMES]


@pytest.mark.parametrize("name", NAMES)
def test_a_foreign_package_imported_before_is_refused(desk: Path, name: str) -> None:
    done = script(desk, f"import {name}\nimport flexura")
    assert done.returncode == 1
    told = done.stderr.strip().splitlines()[-1]
    assert told.startswith(f"ImportError: flexura needs its own package '{name}' in {ROOT}, but")
    assert str(desk / name) in told


def test_a_module_in_place_of_a_package_is_refused_as_well(tmp_path: Path) -> None:
    (tmp_path / "analysis.py").write_text("")
    done = script(tmp_path, "import analysis\nimport flexura")
    assert str(tmp_path / "analysis.py") in done.stderr.strip().splitlines()[-1]


def test_our_packages_imported_before_are_kept(tmp_path: Path) -> None:
    assert script(tmp_path, "import app.files\nimport flexura").returncode == 0


def test_a_part_of_the_foreign_package_is_told_with_its_place(desk: Path) -> None:
    done = script(desk, "import flexura\nimport app.models")
    told = done.stderr.strip().splitlines()[-1]
    assert told.startswith("ModuleNotFoundError: No module named 'app.models': 'app' is Flexura's package")
    assert str(desk / "app") in told


def test_a_missing_part_without_a_foreign_package_is_an_ordinary_error(tmp_path: Path) -> None:
    done = script(tmp_path, "import flexura\nimport app.models")
    assert done.stderr.strip().splitlines()[-1] == "ModuleNotFoundError: No module named 'app.models'"


@pytest.mark.parametrize("words", [("-m", "flexura"), ("-c", "from flexura.__main__ import main; main()")])
def test_the_program_runs_beside_foreign_packages(desk: Path, words: tuple[str, ...]) -> None:
    done = run(desk, *words, "identify", "nowhere")
    assert (done.returncode, "nowhere: does not exist" in done.stderr) == (2, True), done.stderr


def test_processes_started_by_the_program_get_our_packages(desk: Path) -> None:
    """As ``python -m flexura`` starts them: with its ``sys.path``, without its finder."""
    done = run(
        desk,
        "-c",
        "import multiprocessing, os\n"
        "from flexura.own_packages import put_first\n"
        "put_first()\n"
        "import app.files.shipped as shipped\n"
        "pool = multiprocessing.get_context('spawn').Pool(1)\n"
        "print(pool.apply(shipped.shipped, ('pp-plate',)))\n",
    )
    assert done.returncode == 0, done.stderr
    assert Path(done.stdout.strip()) == ROOT / "examples" / "pp-plate"


def test_sys_path_stays_as_it_is_where_nothing_foreign_lies(tmp_path: Path) -> None:
    text = "import sys, flexura.own_packages as o\nbefore = [*sys.path]\no.put_first()\nassert sys.path == before"
    assert script(tmp_path, text).returncode == 0
