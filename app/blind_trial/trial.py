"""A whole trial: its folder, its plates, and its campaigns in worker processes.

===============================  ==================================================================
``trial.json``                   settings of the trial and hash of the thresholds, written first
``truth/NNNN.json``              hidden effects of campaign NNNN
``campaigns/NNNN/``              campaign NNNN, without the truth
``runs/NNNN/gap.json``           the verdict on it
``proof.json``                   comparison of the verdicts with the truth
===============================  ==================================================================
"""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

import analysis.gap.thresholds as frozen
from analysis.progress import Progress
from app.blind_trial.assignments import SHARES, STREAMS, Assignment, Kind, assignments
from app.blind_trial.experiments import any_declaration
from app.blind_trial.judging import is_judged, judge_campaign
from app.blind_trial.making import make_campaign
from app.blind_trial.outcome import read_record
from app.blind_trial.plates import PlateKind, plate_kind
from app.blind_trial.specimen import specimen_operators
from app.files.atomic import write_json
from app.files.bad_file import ResultFileError
from app.files.provenance import provenance, sha256
from app.terminal.end_signals import undisturbed
from app.twins.campaign_twin import campaign_twin, effect_twin
from drivers.interruptions import ENDING

SCHEMA = "flexura-blind-trial/1"
TRIAL = "trial.json"
CAMPAIGNS_PER_PLATE = 25
"""Weight of preparing a plate in the progress, in campaigns: it is reduced twice."""


@dataclass(frozen=True)
class Trial:
    """Settings of a trial.

    Attributes
    ----------
    folder : Path
    count, seed : int
    kinds : tuple of str
    stream : str
        ``trial`` or ``calibration``.
    """

    folder: Path
    count: int
    seed: int
    kinds: tuple[Kind, ...]
    stream: str = "trial"

    @property
    def assignments(self) -> tuple[Assignment, ...]:
        """All campaigns."""
        return assignments(self.count, self.kinds)

    def truth(self, assignment: Assignment) -> Path:
        """File with the truth of a campaign."""
        return self.folder / "truth" / f"{assignment.name}.json"

    def campaign(self, assignment: Assignment) -> Path:
        """Folder of a campaign."""
        return self.folder / "campaigns" / assignment.name

    def run(self, assignment: Assignment) -> Path:
        """Run folder of a campaign."""
        return self.folder / "runs" / assignment.name

    @property
    def plates(self) -> tuple[PlateKind, ...]:
        """Every plate of the trial."""
        count = -(-self.count // CAMPAIGNS_PER_PLATE)
        words = [STREAMS[self.stream], self.seed, 0]
        return tuple(plate_kind(number, np.random.default_rng([*words, number])) for number in range(count))

    def plate(self, assignment: Assignment) -> PlateKind:
        """Return the plate of a campaign: plates are used in turn, with a shift of one per round of kinds."""
        plates, turn = self.plates, assignment.number // sum(SHARES.values())
        return plates[(assignment.number + turn) % len(plates)]

    def record(self) -> dict[str, Any]:
        """Return the content of ``trial.json``."""
        thresholds = sha256(Path(str(frozen.__file__)))
        settings = {"count": self.count, "kinds": list(self.kinds), "stream": self.stream}
        return {"schema": SCHEMA, **provenance({"thresholds": thresholds}, settings, self.seed)}


def begin(trial: Trial) -> dict[str, Any]:
    """Write a trial's settings into its folder, or resume it; ResultFileError if the folder holds another."""
    record, file = trial.record(), trial.folder / TRIAL
    if file.is_file():
        before = read_record(file)
        other = [name for name in record if before.get(name) != record[name]]
        if other:
            raise ResultFileError(
                f"{trial.folder}: holds a trial with another {', '.join(other)}; name another folder with --out"
            )
    else:
        write_json(file, record)
    return record


@contextmanager
def worker_processes(count: int) -> Iterator[Executor]:
    """Yield new worker processes; on an error or a signal to end they end at once, whatever they are at.

    A task takes minutes, and an abandoned pool would work through all its tasks. What was finished stays, and the
    rest is made anew when the trial is taken up. A signal to a worker ends all as one to this process does.

    Raises
    ------
    ResultFileError
        Where a worker was killed, or had too little memory.
    """
    heard = tuple(number for number in ENDING if signal.getsignal(number) is not signal.SIG_IGN)
    context = multiprocessing.get_context("spawn")
    held, holder = context.Pipe(duplex=False)
    with undisturbed():  # inherited: a process that is being started ignores what it cannot pass on yet
        if os.name != "nt":
            from multiprocessing import resource_tracker  # Python's own helper process; absent on Windows

            resource_tracker.ensure_running()
        pool = ProcessPoolExecutor(
            count, mp_context=context, initializer=_follow_the_parent, initargs=(held, heard)
        )
        for _ in range(count):
            pool.submit(os.getpid)
    try:
        yield pool
        pool.shutdown()
    except BrokenProcessPool as error:
        raise ResultFileError(
            "a worker process was killed, or had too little memory; what is finished stays: run it again to go "
            "on, with fewer --workers"
        ) from error
    finally:
        with undisturbed():
            holder.close()
            pool.shutdown(cancel_futures=True)
            held.close()


def _follow_the_parent(held: Connection, heard: tuple[int, ...]) -> None:
    """End this process when its parent lets go of a pipe, or is killed; pass on to it the signals it heeds."""
    parent = multiprocessing.parent_process()
    if parent is None:
        return

    def watch() -> None:
        wait([held, parent.sentinel])
        os._exit(1)

    def pass_on(number: int, _: FrameType | None) -> None:
        if os.name != "nt":  # Windows sends Ctrl-C to the parent, too
            with suppress(ProcessLookupError):
                os.kill(parent.pid or 0, number)

    threading.Thread(target=watch, daemon=True).start()
    for number in heard:
        signal.signal(number, pass_on)


def run_trial(trial: Trial, executor: Executor, report: Progress, announce: Callable[[str], None]) -> None:
    """Make and judge every campaign that has no verdict yet.

    Parameters
    ----------
    trial : Trial
    executor : Executor
        Runs the tasks: plates, then campaigns.
    report : callable
        Called with the stage and the share done.
    announce : callable
        Called with a line of text after every campaign, without its verdict.
    """
    left = [a for a in trial.assignments if not is_judged(trial.run(a))]
    if not left:
        return
    tasks = [(task, kind) for kind in trial.plates for task in (prepare_specimen, prepare_twin)]
    report("plates", 0.0)
    for done, plate in enumerate(as_completed([executor.submit(task, kind) for task, kind in tasks]), 1):
        plate.result()
        report("plates", done / len(tasks))
    jobs = {executor.submit(one_campaign, trial, assignment): assignment for assignment in left}
    before = trial.count - len(left)
    for done, job in enumerate(as_completed(jobs), 1):
        job.result()
        report("campaigns", (before + done) / trial.count)
        announce(f"campaign {jobs[job].name} judged, {len(left) - done} left")


def prepare_specimen(kind: PlateKind) -> None:
    """Put the operators of a plate for the simulated measurement into the cache."""
    specimen_operators(any_declaration(kind))


def prepare_twin(kind: PlateKind) -> None:
    """Put the operators for the analysis of a plate into the cache."""
    campaign_twin(any_declaration(kind), lambda stage, share: None)
    effect_twin(any_declaration(kind), lambda stage, share: None)


def one_campaign(trial: Trial, assignment: Assignment) -> None:
    """Simulate a campaign and compare it; the comparison gets only the campaign's folder and the library."""
    truth, folder = trial.truth(assignment), trial.campaign(assignment)
    make_campaign(assignment, trial.plate(assignment), trial.stream, trial.seed, truth, folder)
    ablated = read_record(truth)["ablated"]
    judge_campaign(folder, trial.run(assignment), [ablated] if ablated else [])
