"""Mutations by the thousand, shared among processes that are ended where they hang."""

import multiprocessing
import shutil
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from tests.fuzz.child import MEMORY, read_mutations
from tests.fuzz.readers import READERS
from tests.fuzz.whole_files import write_all

PATIENCE = 130.0
"""Seconds that reading one file may take: more than `app.files.isolation` gives its child."""
START = 300.0
"""Seconds that a process may take to begin."""
BATCH = 100
"""Mutations to a process."""
DEFECTS = ("traceback", "hang", "memory", "silent")


@dataclass
class Tally:
    """What came of one reader's mutations: how many of each, the first of every defect, the most bytes held."""

    outcomes: Counter[str] = field(default_factory=Counter)
    examples: dict[str, tuple[int, str]] = field(default_factory=dict)
    memory: int = 0

    def take(self, number: int, came: str, said: str, memory: int) -> None:
        """Count one."""
        self.outcomes[came] += 1
        self.memory = max(self.memory, memory)
        if came in DEFECTS:
            key = f"{came}: {said.strip().splitlines()[-1] if said else ''}"
            self.examples.setdefault(key, (number, said))

    @property
    def defects(self) -> int:
        """Mutations that were neither read nor refused as they should."""
        return sum(self.outcomes[came] for came in DEFECTS) + (self.memory > MEMORY)


def fuzz(
    count: int,
    seed: int,
    jobs: int,
    told: Callable[[str], None],
    only: str | None = None,
    patience: float = PATIENCE,
) -> dict[str, Tally]:
    """Read `count` mutations of all kinds of files.

    Parameters
    ----------
    count : int
        Of all kinds together, or of the one kind read alone.
    seed : int
        The same seed and count give the same mutations, however many processes there are.
    jobs : int
        Processes at a time.
    told : callable
        Told in a line of every batch that is done.
    only : str, optional
        The kind to read alone.
    patience : float
        Seconds after which reading a file counts as a hang.

    Returns
    -------
    dict of str to Tally
        By kind.
    """
    tallies = {reader.name: Tally() for reader in READERS if only in (None, reader.name)}
    batches = [
        (place, first, min(first + BATCH, share))
        for place, reader in enumerate(READERS)
        if reader.name in tallies
        for share in [count if only else max(1, round(count * reader.share))]
        for first in range(0, share, BATCH)
    ]
    with TemporaryDirectory() as folder, ThreadPoolExecutor(jobs) as pool:
        whole = Path(folder) / "whole"
        whole.mkdir()
        write_all(whole)

        def run(batch: tuple[int, int, int]) -> tuple[str, list[tuple[int, str, str, int]]]:
            place, first, end = batch
            root = Path(folder) / f"{place}-{first}"
            found = []
            while len(found) < end - first:
                shutil.copytree(whole, root)
                found += _outcomes(root, place, seed, first + len(found), end, patience)
                shutil.rmtree(root)
            return READERS[place].name, found

        for done, (name, found) in enumerate(pool.map(run, batches), 1):
            for outcome in found:
                tallies[name].take(*outcome)
            came = ", ".join(f"{number} {what}" for what, number in tallies[name].outcomes.items())
            told(f"{done} of {len(batches)} batches, {name}: {came}")
    return tallies


def _outcomes(
    root: Path, place: int, seed: int, first: int, end: int, patience: float
) -> Iterator[tuple[int, str, str, int]]:
    """Read a batch in a process, up to its end or to the mutation on which the process hangs or crashes."""
    ours, theirs = multiprocessing.Pipe(duplex=False)
    words = (theirs, root, place, seed, first, end)
    child = _processes().Process(target=read_mutations, args=words, daemon=True)
    child.start()
    theirs.close()
    try:
        if not ours.poll(START) or _received(ours) != "ready":
            raise RuntimeError(f"no process reads the faultless files of {READERS[place].name}")
        for number in range(first, end):
            _received(ours)
            answered = ours.poll(patience)
            outcome = _received(ours) if answered else None
            if outcome is None:
                yield number, *(("traceback", "the process died") if answered else ("hang", "")), 0
                return
            yield number, *outcome
    finally:
        child.kill()
        child.join()
        ours.close()


def _processes() -> Any:
    """Return what makes processes; where the system can, they are forked from one that has imported everything."""
    if "forkserver" not in multiprocessing.get_all_start_methods():
        return multiprocessing.get_context("spawn")
    found = multiprocessing.get_context("forkserver")
    found.set_forkserver_preload(["tests.fuzz.child"])
    return found


def _received(pipe: Any) -> Any:
    try:
        return pipe.recv()
    except EOFError:
        return None
