"""Choose the slow tests that fit into a time; `.ci/run` runs a fifth of them after every commit, in turn.

    pytest --collect-only -q -m slow | python tests/slow_share.py COMMITS SECONDS     prints the tests chosen
    pytest -m slow --durations=0 -vv FILE... | python tests/slow_share.py --keep     notes how long they took

COMMITS, the number of commits, says whose turn it is, and with which test the fifth begins: what does not fit now
comes first a few rounds later. `slow_seconds.json` holds what was measured, by file: the seconds of each function
(their mean, if it is parametrised), and under `set-up` what the tests of the file share, paid once if any of them
runs.
"""

import json
import re
import sys
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from statistics import fmean

SHARES = 5
MEASURED = Path(__file__).with_name("slow_seconds.json")
SET_UP = "set-up"
LONG_SET_UP = 1.0  # s; a folder, a campaign read and a start of a rig that one test has for itself stay below it
DURATION = re.compile(r"\s*([\d.]+)s (setup|call|teardown) +(\S+?\.py)::(.+?)\s*$")


def turn(tests: Sequence[str], commits: int) -> list[str]:
    """Return the fifth whose turn it is, in the order in which its tests are to be begun."""
    share = sorted(tests)[commits % SHARES :: SHARES]
    rounds = commits // SHARES
    begin = rounds * (len(share) // SHARES + 1) % max(1, len(share))
    return share[begin:] + share[:begin]


def fitting(tests: Sequence[str], measured: Mapping[str, Mapping[str, float]], seconds: float) -> list[str]:
    """Return those of the tests, one after the other, for which there is time.

    A function that was not measured is taken to need as long as the longest measured one of its file. Files of
    which none was measured are left out: nobody knows whether an hour is enough.
    """
    chosen, begun = [], set()
    for test in tests:
        file, _, name = test.partition("::")
        known = dict(measured.get(file, {}))
        shared = known.pop(SET_UP, 0.0)
        needed = known.get(name.partition("[")[0], max(known.values(), default=float("inf")))
        if file not in begun:
            needed += shared
        if needed <= seconds:
            chosen.append(test)
            begun.add(file)
            seconds -= needed
    return chosen


def measured_in(lines: Iterable[str]) -> dict[str, dict[str, float]]:
    """Return the seconds in a list of durations, as of ``pytest --durations=0 -vv``.

    A set-up that takes more than a second is what a fixture makes for the tests that follow; shorter ones, and the
    end of a test, are the test's own. What was set up and not called, a skipped test, is left out.
    """
    shared: dict[str, float] = defaultdict(float)
    own: dict[tuple[str, str], float] = defaultdict(float)
    called = set()
    for line in lines:
        if found := DURATION.match(line):
            taken, phase, file, test = float(found[1]), found[2], found[3], found[4]
            if phase == "setup" and taken > LONG_SET_UP:
                shared[file] += taken
            else:
                own[file, test] += taken
            if phase == "call":
                called.add((file, test))
    by_function: dict[str, dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
    for file, test in called:
        by_function[file][test.partition("[")[0]].append(own[file, test])
    kept = {
        file: {name: round(fmean(all_), 1) for name, all_ in names.items()} for file, names in by_function.items()
    }
    for file in kept.keys() & shared.keys():
        kept[file][SET_UP] = round(shared[file], 1)
    return kept


def keep(lines: Iterable[str]) -> None:
    """Replace the seconds of the files whose tests are in a list of durations."""
    measured = json.loads(MEASURED.read_text(encoding="utf-8")) | measured_in(lines)
    text = json.dumps(measured, indent=1, sort_keys=True, ensure_ascii=False)
    MEASURED.write_text(text + "\n", encoding="utf-8")


def main() -> None:
    """Print the tests chosen, a line each, and on the error stream how many of how many."""
    if sys.argv[1] == "--keep":
        keep(sys.stdin)
        return
    tests = [line for line in sys.stdin.read().splitlines() if "::" in line]
    commits, seconds = int(sys.argv[1]), float(sys.argv[2])
    share = turn(tests, commits)
    measured = json.loads(MEASURED.read_text(encoding="utf-8"))
    chosen = fitting(share, measured, seconds)
    unknown = {test.partition("::")[0] for test in tests} - set(measured)
    turn_told = f"share {commits % SHARES + 1} of {SHARES} of {len(tests)}"
    sys.stderr.write(f"slow tests: {len(chosen)} of {len(share)} ({turn_told}) fit into {seconds:.0f} s\n")
    if unknown:
        sys.stderr.write(
            f"slow tests of {len(unknown)} files were never measured, and are left out: CONTRIBUTING.md\n"
        )
    sys.stdout.writelines(f"{test}\n" for test in chosen)


if __name__ == "__main__":
    main()
