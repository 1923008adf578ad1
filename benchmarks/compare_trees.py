"""Whether two checkouts of Flexura find the same in the same campaigns.

    python benchmarks/compare_trees.py ../before . --campaigns examples/pp-plate ../recordings/other

Each checkout runs `identify`, `update` and `gap` on every campaign, in processes of its own, one after the other,
with a cache folder of its own. Verdicts, names, counts and notes have to be equal, numbers within 1e-6 relative of
each other; times, hashes and versions are not compared. What differs is listed with its place in the JSON; exit
status 1 where anything does.
"""

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

VERBS = ("identify", "update", "gap")
OWN = {"seconds", "provenance", "inputs", "flexura", "python", "packages"}
"""Keys that differ from run to run, or from version to version."""
GOOD = (0, 1)
"""Exit statuses that come with a result."""
ZERO = 1e-12
"""Numbers nearer to each other than this are equal: rounding of zeros."""


def found(tree: Path, verb: str, campaign: Path, scratch: Path) -> Any:
    """Return what a verb of one checkout prints as JSON.

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
        As read from JSON.

    Raises
    ------
    SystemExit
        Where the verb refuses the campaign.
    """
    run = scratch / f"{campaign.name}-run"
    package = "flexura" if (tree / "flexura").is_dir() else "app"
    words = [sys.executable, "-P", "-m", package, verb, str(campaign), "--out", str(run), "--json", "--quiet"]
    environment = os.environ | {"PYTHONPATH": str(tree), "FLEXURA_CACHE": str(scratch / "cache")}
    done = subprocess.run(words, env=environment, capture_output=True, text=True, check=False)
    if done.returncode not in GOOD:
        sys.exit(f"{tree}: flexura {verb} {campaign}: exit status {done.returncode}\n{done.stderr}")
    return json.loads(done.stdout)


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


def main() -> int:
    """Compare, and print what differs."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("before", type=Path)
    parser.add_argument("after", type=Path)
    parser.add_argument("--campaigns", type=Path, nargs="+", default=[Path("examples/pp-plate")])
    parser.add_argument("--verbs", nargs="+", choices=VERBS, default=VERBS)
    parser.add_argument("--tolerance", type=float, default=1e-6)
    asked = parser.parse_args()
    count = 0
    with tempfile.TemporaryDirectory() as folder:
        for campaign in asked.campaigns:
            for verb in asked.verbs:
                results = [
                    found(tree.resolve(), verb, campaign.resolve(), Path(folder) / name)
                    for name, tree in (("before", asked.before), ("after", asked.after))
                ]
                told = list(differences(*results, asked.tolerance))
                count += len(told)
                print(f"{campaign} {verb}: {'equal' if not told else f'{len(told)} differences'}", flush=True)
                for line in told:
                    print(f"    {line}")
    return 1 if count else 0


if __name__ == "__main__":
    sys.exit(main())
