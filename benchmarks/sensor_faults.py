"""Simulated faults of the sensors on a plate: how many wrong temperatures are untold, how many told in vain.

    python benchmarks/sensor_faults.py --faults 10000 --healthy 1000

The trials, and what counts, are described in `tests/drivers/rig/sensor_trials.py`. Each takes about 0.3 s.
"""

import argparse
import sys
import time
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.drivers.rig.sensor_trials import KINDS, Trial


def main() -> None:
    """Run the trials, and print what came of them."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--faults", type=int, default=10_000)
    parser.add_argument("--healthy", type=int, default=1_000)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    began = time.perf_counter()
    untold, kept, endings, told = Counter[str](), Counter[str](), Counter[str](), Counter[str]()
    for number in range(options.faults):
        kind = KINDS[number % len(KINDS)]
        trial = Trial(options.seed + number, kind).run()
        kept[kind] += len(trial.labels)
        endings[kind] += trial.ending != "complete"
        told[kind] += bool(trial.told) or trial.ending != "complete"
        untold[kind] += len(trial.untold)
        if trial.untold:
            print(f"untold: seed {trial.seed}, {kind}: {[(round(a, 2), round(b, 2)) for a, b in trial.untold]}")
    print(f"{'fault':16} {'sweeps kept':>12} {'stopped':>8} {'told':>6} {'untold sweeps':>14}")
    for kind in KINDS:
        print(f"{kind:16} {kept[kind]:12} {endings[kind]:8} {told[kind]:6} {untold[kind]:14}")
    false = [
        trial
        for trial in (Trial(options.seed + number).run() for number in range(options.healthy))
        if trial.told or trial.ending != "complete"
    ]
    for trial in false:
        print(f"false: seed {trial.seed}, {trial.ending}: {trial.told[:2]}")
    print(f"{options.faults} faults: {sum(untold.values())} sweeps untold")
    print(f"{options.healthy} healthy campaigns: {len(false)} told in vain; {time.perf_counter() - began:.0f} s")


if __name__ == "__main__":
    main()
