"""The comparison of two checkouts sees what differs, and only that."""

import json
import runpy
from pathlib import Path

SCRIPT = runpy.run_path(str(Path(__file__).resolve().parents[1] / "benchmarks" / "compare_trees.py"))
DIFFERENCES = SCRIPT["differences"]


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


def test_entries_of_a_list_are_gathered() -> None:
    told = DIFFERENCES({"t": [{"f": 1.0}, {"f": 2.0}], "n": 1}, {"t": [{"f": 1.1}, {"f": 2.2}], "n": 2}, 1e-6)
    assert SCRIPT["gathered"](told) == [
        "1 of .n, the first .n: 1 before, 2 after",
        "2 of .t[*].f, the first .t[0].f: 1.0 before, 1.1 after",
    ]


def test_a_checkout_prints_its_own_result_once_and_a_refusal_is_a_result(tmp_path: Path) -> None:
    """Two programs in place of checkouts, the older of which has its entrance elsewhere."""
    for name, package in (("older", "app"), ("newer", "flexura")):
        main = tmp_path / name / package / "__main__.py"
        main.parent.mkdir(parents=True)
        (main.parent / "__init__.py").write_text("")
        main.write_text(
            "import json, sys\n"
            "if sys.argv[1] == 'gap': sys.exit(2)\n"
            f"print(json.dumps({{'who': {name!r}, 'words': sys.argv[1:2]}}))\n"
        )
    campaign = tmp_path / "plate"
    for name in ("older", "newer"):
        found = SCRIPT["found"](tmp_path / name, "update", campaign, tmp_path)
        assert found == {"who": name, "words": ["update"]}
        assert json.loads((tmp_path / "plate-update.json").read_text()) == found
        kept = SCRIPT["found"](tmp_path / "nowhere", "update", campaign, tmp_path)
        assert kept == found
        assert SCRIPT["found"](tmp_path / name, "gap", campaign, tmp_path)["refused"]["status"] == 2
        (tmp_path / "plate-update.json").unlink()
