"""Whether two checkouts of Flexura find the same in the same campaigns.

    python benchmarks/compare_trees.py ../before . --campaigns examples/pp-plate ../other --keep compared

Each checkout runs `identify`, `update`, `gap` and `report` on every campaign, in processes of its own, one after
the other, with a cache folder of its own. Verdicts, names, counts, notes and the list of the report's figures have
to be equal, numbers within 1e-6 relative of each other; times, places of files, hashes and versions are not
compared. What differs is gathered by its place in the JSON, all entries of a list together, with the first of
them; exit status 1 where anything does. What a checkout printed stays in the folder of `--keep` and is not
computed again when the command is typed again: name another folder where a checkout has changed.
"""

import argparse
import json
import math
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import nullcontext
from pathlib import Path
from typing import Any

VERBS = ("identify", "update", "gap", "report")
OWN = {"seconds", "provenance", "inputs", "flexura", "python", "packages", "report", "bytes", "gap_json", "twin"}
"""Keys that differ from run to run, or from version to version."""
GOOD = (0, 1)
"""Exit statuses that come with a result."""
ZERO = 1e-12
"""Numbers nearer to each other than this are equal: rounding of zeros."""


def found(tree: Path, verb: str, campaign: Path, scratch: Path) -> Any:
    """Return what a verb of one checkout prints as JSON, or printed before.

    Parameters
    ----------
    tree : Path
        Checkout.
    verb : str
    campaign : Path
    scratch : Path
        For its results and its cache.

    Returns
    -------
    object
        As read from JSON; of a verb that refuses, its sentence in its place.
    """
    run = scratch / f"{campaign.name}-run"
    printed = scratch / f"{campaign.name}-{verb}.json"
    if not printed.is_file():
        package = "flexura" if (tree / "flexura").is_dir() else "app"
        asked = [str(run)] if verb == "report" else [str(campaign), "--out", str(run)]
        words = [sys.executable, "-P", "-m", package, verb, *asked, "--json", "--quiet"]
        environment = os.environ | {"PYTHONPATH": str(tree), "FLEXURA_CACHE": str(scratch / "cache")}
        done = subprocess.run(words, env=environment, capture_output=True, text=True, check=False)
        if done.returncode not in GOOD:
            return {"refused": {"status": done.returncode, "told": done.stderr.replace(str(scratch), "")}}
        half = printed.with_suffix(".part")
        half.write_text(done.stdout, encoding="utf-8")
        half.replace(printed)
    return json.loads(printed.read_text(encoding="utf-8"))


def differences(before: Any, after: Any, tolerance: float, place: str = "") -> Iterator[str]:
    """Yield what differs between two values read from JSON, each with its place.

    Parameters
    ----------
    before, after : object
    tolerance : float
        Relative, of numbers.
    place : str
        Where in the JSON they stand.

    Yields
    ------
    str
    """
    if isinstance(before, dict) and isinstance(after, dict):
        for key in sorted(before.keys() ^ after.keys()):
            yield f"{place}.{key}: only {'before' if key in before else 'after'}"
        for key in sorted((before.keys() & after.keys()) - OWN):
            yield from differences(before[key], after[key], tolerance, f"{place}.{key}")
    elif isinstance(before, list) and isinstance(after, list):
        if len(before) != len(after):
            yield f"{place}: {len(before)} entries before, {len(after)} after"
        for number, pair in enumerate(zip(before, after, strict=False)):
            yield from differences(*pair, tolerance, f"{place}[{number}]")
    elif _is_number(before) and _is_number(after):
        if not math.isclose(before, after, rel_tol=tolerance, abs_tol=ZERO):
            yield f"{place}: {before!r} before, {after!r} after"
    elif before != after:
        yield f"{place}: {before!r} before, {after!r} after"


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def gathered(told: Iterable[str]) -> list[str]:
    """One line for each place in the JSON, whatever the number in a list: how many differ there, and the first."""
    places: dict[str, list[str]] = {}
    for line in told:
        places.setdefault(re.sub(r"\[\d+\]", "[*]", line.split(": ")[0]), []).append(line)
    return [f"{len(lines)} of {place}, the first {lines[0]}" for place, lines in places.items()]


def main() -> int:
    """Compare, and print what differs."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("before", type=Path)
    parser.add_argument("after", type=Path)
    parser.add_argument("--campaigns", type=Path, nargs="+", default=[Path("examples/pp-plate")])
    parser.add_argument("--verbs", nargs="+", choices=VERBS, default=VERBS)
    parser.add_argument("--tolerance", type=float, default=1e-6)
    parser.add_argument("--keep", type=Path, help="folder for results and caches (default: a temporary one)")
    asked = parser.parse_args()
    absent = [str(campaign) for campaign in asked.campaigns if not campaign.exists()]
    if absent:
        parser.error(f"no such campaign: {', '.join(absent)}")
    count = 0
    with nullcontext(asked.keep) if asked.keep else tempfile.TemporaryDirectory() as folder:
        for campaign in asked.campaigns:
            for verb in asked.verbs:
                results = []
                for name, tree in (("before", asked.before), ("after", asked.after)):
                    scratch = Path(folder).resolve() / name
                    scratch.mkdir(parents=True, exist_ok=True)
                    results.append(found(tree.resolve(), verb, campaign.resolve(), scratch))
                told = list(differences(*results, asked.tolerance))
                count += len(told)
                refused = "refused by both, " if all("refused" in result for result in results) else ""
                print(f"{campaign} {verb}: {refused}{f'{len(told)} differences' if told else 'equal'}", flush=True)
                for line in gathered(told):
                    print(f"    {line}")
    return 1 if count else 0


if __name__ == "__main__":
    sys.exit(main())
