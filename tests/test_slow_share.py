"""Every slow test has its turn within five commits, and in the long run also where few fit into the time."""

import json
from pathlib import Path

import pytest

from tests import slow_share

TESTS = [f"tests/test_a.py::test_{n:03d}" for n in range(123)]


def test_five_commits_are_all_tests_once() -> None:
    shares = [slow_share.turn(TESTS, commits) for commits in range(1000, 1005)]
    assert sorted(test for share in shares for test in share) == TESTS


def test_no_test_is_left_out_for_ever_where_one_fits() -> None:
    measured = {TESTS[0]: 60.0}
    begun = {slow_share.fitting(slow_share.turn(TESTS, commits), measured, 60.0)[0] for commits in range(125 * 5)}
    assert begun == set(TESTS)


def test_those_chosen_fit_and_longer_ones_make_way_for_shorter() -> None:
    measured = {"a": 50.0, "b": 90.0, "c": 30.0, "d.py::known": 4.0}
    tests = ["a", "b", "c", "unknown", "d.py::known", "d.py::unknown"]
    assert slow_share.fitting(tests, measured, 87.0) == ["a", "c", "d.py::known"]
    assert slow_share.fitting(["unknown", "d.py::unknown"], measured, 1e6) == ["d.py::unknown"]


def test_seconds_are_kept_of_what_ran(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(slow_share, "MEASURED", tmp_path / "seconds.json")
    slow_share.MEASURED.write_text('{"tests/b.py::test_c": 3.0}')
    cases = (
        '<testcase classname="tests.app.test_a" name="test_b[1-K]" time="12.34" />'
        '<testcase classname="tests.app.test_a" name="test_s" time="0.0"><skipped /></testcase>'
    )
    (tmp_path / "report.xml").write_text(f"<testsuites><testsuite>{cases}</testsuite></testsuites>")
    slow_share.keep(tmp_path / "report.xml")
    kept = {"tests/app/test_a.py::test_b[1-K]": 12.3, "tests/b.py::test_c": 3.0}
    assert json.loads(slow_share.MEASURED.read_text()) == kept
