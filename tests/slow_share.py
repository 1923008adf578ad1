"""Choose the slow tests that fit into a time; `.ci/run` runs a fifth of them after every commit, in turn.

    pytest --collect-only -q -m slow | python tests/slow_share.py COMMITS SECONDS     prints the tests chosen
    pytest -m slow --junit-xml=FILE tests/app; python tests/slow_share.py --keep FILE     notes how long tests took

COMMITS, the number of commits, says whose turn it is, and with which test the fifth begins: what does not fit now
comes first a few rounds later. `slow_seconds.json` holds what was measured.
"""

import json
import sys
import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping, Sequence
from pathlib import Path

SHARES = 5
MEASURED = Path(__file__).with_name("slow_seconds.json")


def turn(tests: Sequence[str], commits: int) -> list[str]:
    """Return the fifth whose turn it is, in the order in which its tests are to be begun."""
    share = sorted(tests)[commits % SHARES :: SHARES]
    rounds = commits // SHARES
    begin = rounds * (len(share) // SHARES + 1) % max(1, len(share))
    return share[begin:] + share[:begin]


def fitting(tests: Sequence[str], measured: Mapping[str, float], seconds: float) -> list[str]:
    """Return those of the tests, one after the other, for which there is time.

    One that was not measured is taken to need as long as the longest measured one of its file. Files of which none
    was measured are left out: nobody knows whether an hour is enough.
    """
    longest: dict[str, float] = {}
    for test, needed in measured.items():
        file = test.partition("::")[0]
        longest[file] = max(needed, longest.get(file, 0.0))
    chosen = []
    for test in tests:
        needed = measured.get(test, longest.get(test.partition("::")[0], float("inf")))
        if needed <= seconds:
            chosen.append(test)
            seconds -= needed
    return chosen


def keep(report: Path) -> None:
    """Add the seconds of every test in a report (JUnit's XML, as of ``pytest --junit-xml``) to those measured."""
    measured = json.loads(MEASURED.read_text(encoding="utf-8"))
    for case in ElementTree.parse(report).iter("testcase"):  # noqa: S314 (pytest's own file)
        if case.find("skipped") is None:
            name = case.get("classname", "").replace(".", "/") + ".py::" + case.get("name", "")
            measured[name] = round(float(case.get("time", "0")), 1)
    MEASURED.write_text(
        json.dumps(measured, indent=1, sort_keys=True, ensure_ascii=False) + "\n", encoding="utf-8"
    )


def main() -> None:
    """Print the tests chosen, a line each, and on the error stream how many of how many."""
    if sys.argv[1] == "--keep":
        keep(Path(sys.argv[2]))
        return
    tests = [line for line in sys.stdin.read().splitlines() if "::" in line]
    commits, seconds = int(sys.argv[1]), float(sys.argv[2])
    share = turn(tests, commits)
    measured = json.loads(MEASURED.read_text(encoding="utf-8"))
    chosen = fitting(share, measured, seconds)
    unknown = {test.partition("::")[0] for test in tests} - {test.partition("::")[0] for test in measured}
    turn_told = f"share {commits % SHARES + 1} of {SHARES} of {len(tests)}"
    sys.stderr.write(f"slow tests: {len(chosen)} of {len(share)} ({turn_told}) fit into {seconds:.0f} s\n")
    if unknown:
        sys.stderr.write(
            f"slow tests of {len(unknown)} files were never measured, and are left out: CONTRIBUTING.md\n"
        )
    sys.stdout.writelines(f"{test}\n" for test in chosen)


if __name__ == "__main__":
    main()
