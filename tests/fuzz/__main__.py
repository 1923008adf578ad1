"""Damage files of every kind that Flexura reads, and see that each is read or refused in a sentence.

    python -m tests.fuzz                       20,000 mutations, some minutes on two cores
    python -m tests.fuzz --count 500 --only UFF     all 500 of that kind

Prints a table and writes it as JSON; exit status 1 where a file led to a traceback, a hang of more than 40 s, more
than 1 GB of memory, or changed what is read from a file that carries a digest.
"""

import argparse
import json
import sys
import time
from pathlib import Path

from tests.fuzz.campaign import DEFECTS, PATIENCE, Tally, fuzz
from tests.fuzz.readers import READERS


def main() -> int:
    """Run it; 0 where no defect was found."""
    words = argparse.ArgumentParser(prog="python -m tests.fuzz", description=(__doc__ or "").split("\n")[0])
    words.add_argument("--count", type=int, default=20_000, help="mutations (default: %(default)s)")
    words.add_argument("--seed", type=int, default=0)
    words.add_argument("--jobs", type=int, default=2, help="processes at a time (default: %(default)s)")
    words.add_argument("--patience", type=float, default=PATIENCE, help="s that are a hang (default: %(default)g)")
    words.add_argument("--only", choices=[reader.name for reader in READERS], help="one kind of file")
    words.add_argument("--out", type=Path, default=Path("fuzz.json"), help="default: %(default)s")
    asked = words.parse_args()
    begun = time.monotonic()

    def tell(line: str) -> None:
        print(line, file=sys.stderr)

    tallies = fuzz(asked.count, asked.seed, asked.jobs, tell, asked.only, asked.patience)
    show(tallies)
    print(f"{sum(t.outcomes.total() for t in tallies.values())} mutations in {time.monotonic() - begun:.0f} s")
    record = {"count": asked.count, "seed": asked.seed, "kinds": {n: _record(t) for n, t in tallies.items()}}
    asked.out.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    return 1 if any(tally.defects for tally in tallies.values()) else 0


def show(tallies: dict[str, Tally]) -> None:
    """Print the table, then every different defect with the number of its first mutation."""
    columns = ("read", "refused", *DEFECTS)
    print(f"{'':34}" + "".join(f"{name:>11}" for name in (*columns, "most MB")))
    for name, tally in tallies.items():
        cells = [tally.outcomes[column] for column in columns]
        print(f"{name:34}" + "".join(f"{cell:11d}" for cell in (*cells, tally.memory // 1_000_000)))
    for name, tally in tallies.items():
        for key, (number, said) in tally.examples.items():
            print(f"\n{name}, mutation {number}: {key}\n{said}")


def _record(tally: Tally) -> dict[str, object]:
    return {
        **dict(tally.outcomes),
        "most_bytes": tally.memory,
        "defects": {key: number for key, (number, _) in tally.examples.items()},
    }


if __name__ == "__main__":
    sys.exit(main())
