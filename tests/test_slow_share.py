"""Every slow test has its turn within five commits, and in the long run also where few fit into the time."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests import slow_share

TESTS = [f"tests/test_a.py::test_{n:03d}" for n in range(123)]


def test_five_commits_are_all_tests_once() -> None:
    shares = [slow_share.turn(TESTS, commits) for commits in range(1000, 1005)]
    assert sorted(test for share in shares for test in share) == TESTS


def test_no_test_is_left_out_for_ever_where_one_fits() -> None:
    measured = {"tests/test_a.py": {"test_000": 60.0}}
    begun = {slow_share.fitting(slow_share.turn(TESTS, commits), measured, 60.0)[0] for commits in range(125 * 5)}
    assert begun == set(TESTS)


def test_those_chosen_fit_and_longer_ones_make_way_for_shorter() -> None:
    measured = {"a.py": {"test": 50.0, "test_long": 90.0}, "b.py": {"test": 30.0}, "d.py": {"known": 4.0}}
    tests = ["a.py::test", "a.py::test_long", "b.py::test[1]", "c.py::unknown", "d.py::known", "d.py::unknown"]
    assert slow_share.fitting(tests, measured, 87.0) == ["a.py::test", "b.py::test[1]", "d.py::known"]
    assert slow_share.fitting(tests[3:4] + tests[5:], measured, 1e6) == ["d.py::unknown"]


def test_what_the_tests_of_a_file_share_is_paid_once_and_by_whichever_runs() -> None:
    measured = {"a.py": {"set-up": 100.0, "test_b": 1.0, "test_c": 2.0}}
    tests = ["a.py::test_c[x::y]", "a.py::test_b", "a.py::test_new"]
    assert slow_share.fitting(tests[:1], measured, 101.0) == []
    assert slow_share.fitting(tests, measured, 103.0) == tests[:2]
    assert slow_share.fitting(tests, measured, 105.0) == tests


def test_seconds_are_kept_of_what_ran(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(slow_share, "MEASURED", tmp_path / "seconds.json")
    slow_share.MEASURED.write_text('{"tests/b.py": {"test_c": 3.0}, "tests/app/test_a.py": {"test_gone": 8.0}}')
    report = """\
        ============= slowest durations =============
        208.29s setup    tests/app/test_a.py::test_b[1-K]
        10.00s call     tests/app/test_a.py::test_b[a, b::c]
        12.00s call     tests/app/test_a.py::test_b[1-K]
        0.20s teardown tests/app/test_a.py::test_b[1-K]
        0.40s setup    tests/app/test_a.py::test_b[a, b::c]
        0.00s setup    tests/app/test_a.py::test_skipped
        2.00s setup    tests/test_skipped.py::test_skipped
        1 passed in 0.23s
    """
    slow_share.keep(report.splitlines())
    kept = {"tests/app/test_a.py": {"set-up": 208.3, "test_b": 11.3}, "tests/b.py": {"test_c": 3.0}}
    assert json.loads(slow_share.MEASURED.read_text()) == kept


def test_what_is_kept_is_what_pytest_prints(tmp_path: Path) -> None:
    """A file of two parametrised tests with a fixture that takes 1.2 s, run by pytest itself."""
    (tmp_path / "test_it.py").write_text(
        "import time, pytest\n"
        "@pytest.fixture(scope='module')\ndef made(): time.sleep(1.2)\n"
        "@pytest.mark.parametrize('n', ['1', 'a b'])\ndef test_it(made, n): time.sleep(0.2)\n"
    )
    words = ["-m", "pytest", "--durations=0", "-vv", "-p", "no:cacheprovider", "test_it.py"]
    ran = subprocess.run([sys.executable, *words], cwd=tmp_path, capture_output=True, text=True, check=True)
    kept = slow_share.measured_in(ran.stdout.splitlines())
    assert list(kept) == ["test_it.py"]
    assert sorted(kept["test_it.py"]) == ["set-up", "test_it"]
    assert kept["test_it.py"]["set-up"] >= 1.2
    assert kept["test_it.py"]["test_it"] >= 0.2
