"""Reduced models built by workers before they are needed: the plate's while sweeps are read, the panel's beside.

A worker leaves its model in the cache, where the stage that needs it finds it. A model that cannot be built is
built again by that stage, which says what is wrong.
"""

from collections.abc import Callable
from concurrent.futures import Executor, Future
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from pathlib import Path

from analysis.experiment import Experiment
from analysis.focusing.panel import Panel
from analysis.progress import Progress
from app.files.bad_file import ResultFileError

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
    from app.twins.campaign_twin import effect_twin

    with suppress(*FAULTS):
        effect_twin(Experiment.model_validate_json(declared), silent)


def build_panel(declared: str) -> None:
    """Build the model of a panel, given as JSON."""
    from analysis.focusing.grid import Grid
    from app.twins.panel_twin import panel_reduction

    panel = Panel.model_validate_json(declared)
    with suppress(*FAULTS):
        panel_reduction(panel, Grid.of(panel), silent)


def memory_left() -> float:
    """Bytes of memory that can be used without swapping; infinity where the system does not say."""
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        return 1024.0 * float(next(line.split()[1] for line in lines if line.startswith("MemAvailable:")))
    except (OSError, StopIteration, ValueError):
        return float("inf")


class ModelsAhead:
    """Models of one run.

    Parameters
    ----------
    executor : Executor or None
        Of worker processes; None builds each model where it is needed.
    """

    def __init__(self, executor: Executor | None) -> None:
        self._executor = executor
        self._begun: dict[str, Future[None]] = {}
        self._later: list[tuple[str, Callable[[str], None], str]] = []

    def begin(self, experiment: Experiment, panel: Panel | None, *, effects: bool) -> None:
        """Let workers build the models of a run, one after the other where memory is short.

        Parameters
        ----------
        experiment : Experiment
            Whose plate is updated.
        panel : Panel or None
            None where no filters are wanted, or the panel's plate is the one measured, which is not known yet.
        effects : bool
            Whether effects will be searched for.
        """
        if self._executor is None:
            return
        declared = experiment.model_dump_json()
        tasks: list[tuple[str, Callable[[str], None], str]] = [(PLATE, build_plate, declared)]
        if panel is not None:
            tasks.append((PANEL, build_panel, panel.model_dump_json()))
        if effects:  # rests on the plate's model
            self._later.append((EFFECTS, build_effects, declared))
        count = len(tasks) if memory_left() >= SIDE_BY_SIDE else 1
        self._later[:0] = tasks[count:]
        for task in tasks[:count]:
            self._submit(*task)

    def wait_for(self, model: str, report: Progress) -> None:
        """Return when no worker is at a model, `PLATE`, `EFFECTS` or `PANEL`; then the next may be begun."""
        for name in dict.fromkeys((PLATE, model)):
            begun = self._begun.pop(name, None)
            if begun is None:
                continue
            if not begun.done():
                report(f"model of {name}", 0.0)
            with suppress(BrokenProcessPool):  # a worker was killed: the stage builds the model itself
                begun.result()
            report(f"model of {name}", 1.0)
            later, self._later = self._later, []
            for task in later:
                self._submit(*task)

    def _submit(self, name: str, build: Callable[[str], None], declared: str) -> None:
        if self._executor is not None:
            with suppress(BrokenProcessPool):
                self._begun[name] = self._executor.submit(build, declared)
