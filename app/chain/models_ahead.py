"""Reduced models built by workers before they are needed: the plate's while sweeps are read, the panel's beside.

A worker leaves its model in the cache, where the stage that needs it finds it. A model that cannot be built is
built again by that stage, which says what is wrong.
"""

from collections.abc import Sequence
from concurrent.futures import Executor, Future
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from dataclasses import dataclass

from analysis.experiment import Experiment
from analysis.focusing.panel import Panel
from analysis.progress import Progress
from app.files.bad_file import ResultFileError
from app.files.disk_room import memory_left

SIDE_BY_SIDE = 3e9
"""Bytes of free memory from which on two are built at a time: the plate's takes 0.9 GB, the panel's 1.6."""
PLATE, EFFECTS, PANEL = "the plate", "the plate with effects", "the panel"
FAULTS = (ResultFileError, ValueError, OSError, MemoryError)


def silent(stage: str, share: float) -> None:
    """Report no progress: workers have no terminal of their own."""


def build_plate(declared: str) -> None:
    """Build the models of a plate, its experiment given as JSON, that model updating needs."""
    from app.twins.campaign_twin import campaign_twin, tolerant_twin

    experiment = Experiment.model_validate_json(declared)
    with suppress(*FAULTS):
        campaign_twin(experiment, silent)
        tolerant_twin(experiment, silent)


def build_effects(declared: str) -> None:
    """Build the model of a plate with the library's effects."""
    from app.twins.campaign_twin import effect_twin, offset_wanted

    experiment = Experiment.model_validate_json(declared)
    with suppress(*FAULTS):
        effect_twin(experiment, silent, offset=offset_wanted(experiment))


def build_panel(declared: str) -> None:
    """Build the model of a panel, given as JSON."""
    from analysis.focusing.energy import Grid
    from app.twins.panel_twin import panel_reduction

    panel = Panel.model_validate_json(declared)
    with suppress(*FAULTS):
        panel_reduction(panel, Grid.of(panel), silent)


BUILD = {PLATE: build_plate, EFFECTS: build_effects, PANEL: build_panel}


@dataclass(frozen=True)
class WantedModel:
    """A model to be built: `PLATE`, `EFFECTS` or `PANEL`, and its declaration as JSON."""

    kind: str
    declared: str


class ModelsAhead:
    """Models of one run.

    Parameters
    ----------
    wanted : sequence of WantedModel
        In the order in which they are needed; the one with effects rests on the plate's.
    """

    def __init__(self, wanted: Sequence[WantedModel] = ()) -> None:
        self._wanted = list(wanted)
        self._begun: dict[str, Future[None]] = {}
        self._executor: Executor | None = None

    @property
    def at_once(self) -> int:
        """How many are built side by side: one, where memory is short."""
        count = sum(one.kind != EFFECTS for one in self._wanted)
        return min(count, 2 if memory_left() >= SIDE_BY_SIDE else 1)

    def begin(self, executor: Executor | None) -> None:
        """Let workers build the first of them; without workers, each is built where it is needed."""
        self._executor = executor
        for _ in range(max(self.at_once, 1)):
            self._next()

    def wait_for(self, kind: str, report: Progress) -> None:
        """Return when no worker is at a model, or at the plate's, on which others rest; the next are begun."""
        for one in dict.fromkeys((PLATE, kind)):
            while one not in self._begun and any(left.kind == one for left in self._wanted) and self._executor:
                self._next()
            begun = self._begun.pop(one, None)
            if begun is None:
                continue
            if not begun.done():
                report(f"model of {one}", 0.0)
            begun.exception()  # whatever it was, the stage builds the model itself, and says what is wrong
            report(f"model of {one}", 1.0)
            self._next()

    def _next(self) -> None:
        if self._executor is None or not self._wanted:
            return
        one = self._wanted.pop(0)
        with suppress(BrokenProcessPool):  # a worker was killed, or had too little memory
            self._begun[one.kind] = self._executor.submit(BUILD[one.kind], one.declared)
