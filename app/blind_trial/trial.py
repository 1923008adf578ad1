"""A whole trial: its folder, its plates, and its campaigns in worker processes.

===============================  ==================================================================
``trial.json``                   settings of the trial and hash of the thresholds, written first
``truth/NNNN.json``              hidden effects of campaign NNNN
``campaigns/NNNN/``              campaign NNNN, without the truth
``runs/NNNN/gap.json``           the verdict on it
``proof.json``                   comparison of the verdicts with the truth
===============================  ==================================================================
"""

import shutil
from collections.abc import Callable
from concurrent.futures import Executor, as_completed
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import analysis.gap.thresholds as frozen
from analysis.progress import Progress
from app.blind_trial.assignments import SHARES, STREAMS, Assignment, Kind, assignments
from app.blind_trial.experiments import any_declaration
from app.blind_trial.making import make_campaign
from app.blind_trial.outcome import is_judged, judge_campaign, read_record
from app.blind_trial.plates import PlateKind, as_built, plate_kind
from app.blind_trial.specimen import specimen_operators
from app.files.atomic import write_json
from app.files.bad_file import ResultFileError
from app.files.provenance import provenance, sha256
from app.twins.campaign_twin import campaign_twin, effect_twin

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
    exact : bool
        Whether plates are exactly as declared, without nuisances.
    """

    folder: Path
    count: int
    seed: int
    kinds: tuple[Kind, ...]
    stream: str = "trial"
    exact: bool = False

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

    @property
    def built(self) -> tuple[PlateKind | None, ...]:
        """Every plate as it is, nobody tells how; None where it is as declared."""
        if self.exact:
            return (None,) * len(self.plates)
        words = [STREAMS[self.stream], self.seed, 3]
        return tuple(
            as_built(kind, np.random.default_rng([*words, number])) for number, kind in enumerate(self.plates)
        )

    def plate(self, assignment: Assignment) -> tuple[PlateKind, PlateKind | None]:
        """Return the plate of a campaign, as declared and as built.

        Plates are used in turn, with a shift of one per round of kinds.
        """
        plates, turn = self.plates, assignment.number // sum(SHARES.values())
        place = (assignment.number + turn) % len(plates)
        return plates[place], self.built[place]

    def record(self) -> dict[str, Any]:
        """Return the content of ``trial.json``."""
        thresholds = sha256(Path(str(frozen.__file__)))
        settings = {"count": self.count, "kinds": list(self.kinds), "stream": self.stream, "exact": self.exact}
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
    tasks = [(prepare_twin, kind) for kind in trial.plates]
    tasks += [(prepare_specimen, built or kind) for kind, built in zip(trial.plates, trial.built, strict=True)]
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
    for remains in (trial.folder / "campaigns").glob(".*"):  # of workers that were killed
        shutil.rmtree(remains, ignore_errors=True)


def prepare_specimen(kind: PlateKind) -> None:
    """Put the operators of a plate for the simulated measurement into the cache."""
    specimen_operators(any_declaration(kind))


def prepare_twin(kind: PlateKind) -> None:
    """Put the operators for the analysis of a plate into the cache."""
    campaign_twin(any_declaration(kind), lambda stage, share: None)
    effect_twin(any_declaration(kind), lambda stage, share: None)


def one_campaign(trial: Trial, assignment: Assignment) -> None:
    """Simulate a campaign and compare it; the comparison gets only the campaign's folder and the library.

    It may be begun twice at a time: a cluster gives a task to another worker when the first no longer answers.
    Each works in a folder of its own, and what one has finished the other leaves alone.
    """
    truth, folder, run = trial.truth(assignment), trial.campaign(assignment), trial.run(assignment)
    if is_judged(run):
        return
    kind, built = trial.plate(assignment)
    folder.parent.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory(dir=folder.parent, prefix=f".{assignment.name}-") as place:
        made, judged = Path(place) / folder.name, Path(place) / "run"
        make_campaign(assignment, kind, trial.stream, trial.seed, truth, made, built)
        told = read_record(truth)
        judge_campaign(made, judged, [*filter(None, [told["ablated"]]), *told["untold"]])
        if is_judged(run):
            return
        for old in folder.parent.glob(f"{folder.name}*"):  # of a trial that was stopped
            shutil.rmtree(old, ignore_errors=True)
        shutil.rmtree(run, ignore_errors=True)
        run.parent.mkdir(parents=True, exist_ok=True)
        for one in Path(place).iterdir():  # the verdict last: with it a campaign counts as done
            if one != judged:
                _moved(one, folder.parent / one.name)
        _moved(judged, run)


def _moved(one: Path, target: Path) -> None:
    """Give a folder its name, unless another worker was quicker: then the content is the same."""
    try:
        one.rename(target)
    except OSError:
        if not target.is_dir():
            raise
