"""The comparison of two checkouts sees what differs, and only that."""

import runpy
from pathlib import Path

DIFFERENCES = runpy.run_path(str(Path(__file__).resolve().parents[1] / "benchmarks" / "compare_trees.py"))[
    "differences"
]


def test_numbers_within_the_tolerance_and_times_are_equal() -> None:
    before = {"e": 2.0e9, "names": ["a", None], "ok": True, "seconds": 3.0}
    after = {"e": 2.0e9 * (1 + 0.9e-6), "names": ["a", None], "ok": True, "seconds": 5.0}
    assert list(DIFFERENCES(before, after, 1e-6)) == []


def test_what_differs_is_told_with_its_place() -> None:
    before = {"a": [1.0, {"b": "x"}], "gone": 1}
    after = {"a": [1.0 + 2e-6, {"b": "y"}, 3]}
    assert list(DIFFERENCES(before, after, 1e-6)) == [
        ".gone: only before",
        ".a: 2 entries before, 3 after",
        ".a[0]: 1.0 before, 1.000002 after",
        ".a[1].b: 'x' before, 'y' after",
    ]
    assert list(DIFFERENCES({"ok": True}, {"ok": False}, 1e-6)) == [".ok: True before, False after"]
