"""Simulated faults of the sensors on a plate: how many wrong temperatures are untold, how many told in vain.

    python benchmarks/sensor_faults.py --faults 10000 --healthy 1000
    python benchmarks/sensor_faults.py --faults 10000 --healthy 1000 --keep trials.jsonl

The trials, and what counts, are described in `tests/drivers/rig/sensor_trials.py`. Each takes about 0.3 s. With
`--keep`, each is a line of a file, and those that are there are not run again: an interruption loses nothing.
Another file is needed where the rules have changed.
"""

import argparse
import json
import sys
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.drivers.rig.sensor_trials import KINDS, Trial


@dataclass(frozen=True)
class Outcome:
    """What came of one trial: sweeps kept, how it ended, what was told first, (label, true) of untold sweeps."""

    seed: int
    kind: str
    kept: int
    ending: str
    told: list[str]
    untold: list[tuple[float, float]]


def outcome(seed: int, kind: str) -> Outcome:
    """Run one trial; a kind of "" is a healthy campaign."""
    trial = Trial(seed, kind).run()
    untold = [(round(label, 2), round(true, 2)) for label, true in trial.untold]
    return Outcome(seed, kind, len(trial.labels), trial.ending, trial.told[:2], untold)


def outcomes(trials: list[tuple[int, str]], keep: Path | None) -> Iterator[Outcome]:
    """Run the trials, seed and kind of each, that are not in the file yet; yield all."""
    lines = keep.read_text("utf-8").splitlines() if keep is not None and keep.exists() else []
    known = {(one.seed, one.kind): one for one in (Outcome(**json.loads(line)) for line in lines)}
    for seed, kind in trials:
        if (seed, kind) in known:
            yield known[seed, kind]
            continue
        found = outcome(seed, kind)
        if keep is not None:
            with keep.open("a", encoding="utf-8") as file:
                file.write(f"{json.dumps(asdict(found))}\n")
        yield found


def main() -> None:
    """Run the trials, and print what came of them."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--faults", type=int, default=10_000)
    parser.add_argument("--healthy", type=int, default=1_000)
    parser.add_argument("--seed", type=int, default=0, help="of the first trial")
    parser.add_argument("--kind", choices=KINDS, help="only faults of this kind")
    parser.add_argument("--keep", type=Path, help="file of the trials that were run, one a line")
    options = parser.parse_args()
    began = time.perf_counter()
    untold, kept, endings, told, count = (Counter[str]() for _ in range(5))
    seeds = range(options.seed, options.seed + options.faults)
    faults = [(seed, KINDS[seed % len(KINDS)]) for seed in seeds]
    faults = [one for one in faults if options.kind in (None, one[1])]
    for trial in outcomes(faults, options.keep):
        kind = trial.kind
        count[kind] += 1
        kept[kind] += trial.kept
        endings[kind] += trial.ending != "complete"
        told[kind] += bool(trial.told) or trial.ending != "complete"
        untold[kind] += len(trial.untold)
        if trial.untold:
            print(f"untold: seed {trial.seed}, {kind}: {trial.untold}", flush=True)
    print(f"{'fault':16} {'trials':>7} {'sweeps kept':>12} {'stopped':>8} {'told':>6} {'untold sweeps':>14}")
    for kind in count:
        print(f"{kind:16} {count[kind]:7} {kept[kind]:12} {endings[kind]:8} {told[kind]:6} {untold[kind]:14}")
    print(f"{len(faults)} faults: {sum(untold.values())} sweeps untold", flush=True)
    false = 0
    for trial in outcomes([(options.seed + number, "") for number in range(options.healthy)], options.keep):
        if trial.told or trial.ending != "complete":
            false += 1
            print(f"false: seed {trial.seed}, {trial.ending}: {trial.told}", flush=True)
    print(f"{options.healthy} healthy campaigns: {false} told in vain; {time.perf_counter() - began:.0f} s")


if __name__ == "__main__":
    main()
