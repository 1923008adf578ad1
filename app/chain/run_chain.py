"""Stages of a run in order: those up to date skipped, the others made; a failure stops only what needs it."""

import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from analysis.progress import Progress
from app.chain.links import LINKS, Link
from app.chain.work import Made, RunRequest, Work
from app.files.bad_file import ResultFileError
from app.files.campaign_error import CampaignFileError
from app.files.campaigns.of_run import campaign_typed, remember_campaign
from app.files.declarations.run_settings import Stage
from app.files.disk_room import room_of, told
from app.files.results.run_folder import run_folder
from app.files.results.run_record import (
    RunRecord,
    StageRecord,
    hashed,
    read_run_record,
    versions,
    write_run_record,
)
from app.terminal.end_signals import undisturbed

if TYPE_CHECKING:
    from app.chain.models_ahead import WantedModel

DRAWN_FIRST = ("frf.h5", "modes.h5", "laws.h5", "gap.h5")
"""Parts of the report that are final before filters are designed."""
READ_BY_LATER: tuple[Stage, ...] = ("identify", "update")
"""Stages whose results others read beside the sweeps."""


@dataclass(frozen=True)
class RunListener:
    """To whom a run speaks.

    Attributes
    ----------
    stage : callable
        Called with a stage's name and its record when it is done, skipped or failed.
    progress : callable
        Returns a context manager whose value takes a stage's name and the share done.
    workers : callable
        Called with the number of models to be built; returns a context manager whose value is an executor of
        worker processes, or None.
    """

    stage: Callable[[Stage, StageRecord], None]
    progress: Callable[[], AbstractContextManager[Progress]]
    workers: Callable[[int], AbstractContextManager[Executor | None]]


class _StageError(Exception):
    """A stage failed; the message is the sentence for people."""


def run_chain(request: RunRequest, listener: RunListener) -> RunRecord:
    """Run the stages asked for.

    Returns
    -------
    RunRecord
        As ``run.json`` in the run folder: the stages of this run, and those of earlier ones.

    Raises
    ------
    CampaignFileError
        For a campaign that cannot be read or imported.
    ResultFileError
        For a run folder that cannot be written, and for files and a device that the options name and that are not
        there: not after minutes of other stages.
    OSError
        Where ``run.json`` cannot be written.
    """
    _require_named(request)
    with run_folder(request.campaign, request.out, room_of(request.campaign)) as run, ExitStack() as stack:
        chain = _Chain(request, listener, stack, run)
        for stage in request.stages:
            if stage != "import" or request.imported is not None:
                chain.do(stage)
        return chain.ended()


def _require_named(request: RunRequest) -> None:
    """Raise ResultFileError for what stages of a run are told to use, and cannot."""
    options, stages = request.options, set(request.stages)
    settings = options.settings
    for key, named, users in (
        ("effects", settings.effects, {"gap"}),
        ("focus.panel", settings.focus.panel, {"focus", "compensate"}),
        ("compensate.weather", settings.compensate.weather, {"compensate"}),
    ):
        path = options.path(named)
        if users & stages and path is not None and not path.exists():
            raise ResultFileError(
                f"option {key} of [run]: {path} is not there; name what is there, or leave it out"
            )
    if "compensate" in stages and settings.compensate.device != "cpu":
        from app.stages.panel.inputs import checked_device

        checked_device(settings.compensate.device)


TELL_THEIR_CAMPAIGN = ("identify", "update", "gap")
"""Stages whose results say of which campaign they are."""


class _Chain:
    """One run under way."""

    def __init__(self, request: RunRequest, listener: RunListener, stack: ExitStack, run: Path) -> None:
        self._request = request
        self._listener = listener
        self._record = read_run_record(run, str(request.campaign))
        self._work = Work(request, run)
        self._states: dict[str, StageRecord] = {}
        self._workers = False
        self._pool = stack.enter_context(ExitStack())

    def do(self, stage: Stage) -> None:
        """Skip, make or leave out a stage."""
        link = LINKS[stage]
        missing: list[str] = [need for need in link.needs if need in self._states and not self._states[need].whole]
        if missing:
            self._note(stage, StageRecord("not run", f"it needs {missing[0]}, which has no result"))
            return
        if stage == "report" and not (self._work.run / "frf.h5").is_file():
            self._note(stage, StageRecord("not run", "there is no result yet that could be reported"))
            return
        known = None if self._request.force else self._known(stage, link)
        if known is not None:
            if stage in TELL_THEIR_CAMPAIGN:  # it may have been refused when the result was written
                remember_campaign(self._work.run, self._work.folder)
            self._note(stage, known)
        else:
            self._make(stage, link)
        if stage == "update" and self._workers and not self._states[stage].whole:
            self._start_workers()  # nobody needs the models at which workers are, and the report needs workers
        if stage in ("update", "gap") and self._workers and "gap" not in self._to_come(stage):
            self._draw_ahead()

    def ended(self) -> RunRecord:
        """Write and return the record with what was found in words."""
        made = any(state.state == "made" for state in self._states.values())
        if made or not self._record.found:
            from app.chain.found import found_rows

            found = found_rows(self._work.run, campaign_typed(self._work.folder, self._work.run))
            self._record = replace(self._record, found=found)
            write_run_record(self._work.run, self._record)
        return replace(self._record, stages={**self._record.stages, **self._states})

    def _to_come(self, stage: Stage) -> tuple[Stage, ...]:
        return self._request.stages[self._request.stages.index(stage) + 1 :]

    def _known(self, stage: Stage, link: Link) -> StageRecord | None:
        """Return the record of a result that need not be made again."""
        work, before = self._work, self._record.stages.get(stage)
        inputs, settings = link.inputs(work), dict(link.settings(work))
        if before is not None and before.holds(work.place(stage), inputs, settings):
            return replace(before, state="up to date")
        if any(self._states[one].state == "made" for one in READ_BY_LATER if one in self._states):
            return (
                None  # provenance does not tell which modes were paired, nor beside which laws effects were found
            )
        from app.chain.made_by_verbs import made_alike

        good = made_alike(work, stage, {} if before is None else before.results)
        if good is None:
            return None
        results, said = hashed(work.run, link.results), f"made by flexura {stage}"
        return StageRecord("up to date", said, good, inputs, settings, versions(), results)

    def _make(self, stage: Stage, link: Link) -> None:
        """Make a result, and record it; an interruption leaves the records of the stages before."""
        work = self._work
        self._begin_workers(stage, link)
        inputs, started = link.inputs(work), time.perf_counter()
        try:
            with self._listener.progress() as report, _faults():
                made = link.make(work, report)
                if stage in TELL_THEIR_CAMPAIGN:
                    remember_campaign(work.run, work.folder)
        except _StageError as error:
            work.broken.add(stage)
            self._note(stage, StageRecord("failed", str(error), good=False, seconds=time.perf_counter() - started))
            return
        except KeyboardInterrupt:
            with undisturbed():
                self._note(stage, StageRecord("stopped", "it was not finished", good=False))
            raise
        seconds = time.perf_counter() - started
        results, settings = hashed(work.place(stage), link.results), dict(link.settings(work))
        if stage == "import" and work.in_place:
            results = {}
        if stage == "gap":  # which writes laws.h5 where there is none
            inputs = link.inputs(work)
        self._note(stage, _record_of(made, inputs, settings, results, seconds))

    def _begin_workers(self, stage: Stage, link: Link) -> None:
        """Read the campaign, and begin what other processors can do meanwhile."""
        work = self._work
        if stage == "import":
            return
        if link.reads_campaign:
            assert work.campaign  # noqa: S101 (an unreadable campaign ends the run here, before anything is made)
        if self._workers:
            return
        self._workers = True
        self._start_workers(work.models_wanted() if link.reads_campaign else ())

    def _start_workers(self, wanted: "Sequence[WantedModel]" = ()) -> None:
        """Start workers for models and figures, in place of those that are there."""
        from app.chain.models_ahead import ModelsAhead  # slow imports, for a run that has something to do
        from app.report.written import DrawnParts

        work = self._work
        self._pool.close()
        work.models = ModelsAhead(wanted)
        executor = self._pool.enter_context(self._listener.workers(work.models.at_once))
        work.models.begin(executor)
        work.parts = DrawnParts(executor, png=work.settings.report.pictures)
        if "report" in self._request.stages:
            work.parts.make_ready()

    def _draw_ahead(self) -> None:
        if "report" in self._request.stages:
            for name in DRAWN_FIRST:
                self._work.parts.begin(self._work.run, name)

    def _note(self, stage: Stage, state: StageRecord) -> None:
        """Keep a stage's record, on the disk, too, unless nothing has changed."""
        self._states[stage] = state
        kept = replace(state, state="made") if state.whole else state
        if self._record.stages.get(stage) != kept:
            self._record = self._record.with_stage(stage, kept)
            write_run_record(self._work.run, self._record)
        self._listener.stage(stage, state)


def _record_of(
    made: Made, inputs: dict[str, str], settings: dict[str, Any], results: dict[str, str], seconds: float
) -> StageRecord:
    took = round(seconds, 3)
    told = (made.notes, took, made.seed)
    return StageRecord("made", made.said, made.good, inputs, settings, versions(), results, *told)


@contextmanager
def _faults() -> Iterator[None]:
    """Turn what a stage refuses, or a disk, into one sentence; a defect keeps its traceback."""
    from analysis.compensation.evidence_collapse import EvidenceCollapseError

    try:
        yield
    except (CampaignFileError, ResultFileError) as error:
        raise _StageError(str(error)) from error
    except EvidenceCollapseError as error:
        raise _StageError(f"refused: {error}") from error
    except MemoryError as error:
        raise _StageError("there is not enough memory; close other programs, then run this again") from error
    except OSError as error:
        sentence = told(error)
        if sentence is None:
            raise
        raise _StageError(sentence) from error
