"""Which panel's filters can be used for which: the contrast that each panel's filters have on each other panel.

The filters designed with one piece's laws are played, at the temperatures they were designed for, on the twin of
the panel with another piece's laws; what is lost against that piece's own filters is what exchanging them costs.
"""

from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from analysis.arrays import Complex, Real
from analysis.checked_fields import check_shapes
from analysis.progress import Progress
from app.files.bad_file import ResultFileError

if TYPE_CHECKING:
    from analysis.focusing.energy import EnergyForms

FILTERS = "filters.h5"
USABLE_LOSS = 0.02
"""Mean contrast that other filters may lose, as `flexura compensate` allows its networks."""
MOST_TEMPERATURES = 3
"""Lowest, middle, highest that two panels' filters have in common."""


@dataclass(frozen=True)
class Exchange:
    """Loss of contrast by exchanged filters.

    Attributes
    ----------
    names : tuple of str
        Of N panels.
    loss : (N, N) ndarray
        Mean over band and temperatures of what the filters of the panel in the row lose on that in the column;
        NaN where the two have no design in common.
    notes : tuple of str
    """

    names: tuple[str, ...]
    loss: Real
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        check_shapes(self, loss="N N")

    def users_of(self, row: int) -> tuple[str, ...]:
        """Names of the other panels on which a panel's filters are good enough."""
        others = zip(self.names, self.loss[row], strict=True)
        return tuple(name for place, (name, lost) in enumerate(others) if place != row and lost <= USABLE_LOSS)


def exchanged(runs: Mapping[str, Path], executor: Executor, report: Progress) -> Exchange | None:
    """Compare the filters of all runs that have some; None for fewer than two.

    Parameters
    ----------
    runs : mapping of str to Path
        Run folders by name.
    executor : Executor
        Takes a task a panel.
    report : callable
        Called with the stage and the share done.
    """
    known = {name: run for name, run in runs.items() if (run / FILTERS).is_file()}
    if len(known) < 2:
        return None
    report("exchanged filters", 0.0)
    tasks = {name: executor.submit(losses_on, run, list(known.values())) for name, run in known.items()}
    columns, notes = [], []
    for count, (name, task) in enumerate(tasks.items(), start=1):
        column, said = task.result()
        columns.append(column)
        notes += [f"{name}: {said}"] if said else []
        report("exchanged filters", count / len(known))
    return Exchange(tuple(known), np.stack(columns, axis=1), tuple(notes))


def losses_on(run: Path, others: list[Path]) -> tuple[Real, str]:
    """Return what the filters of other runs lose on the panel of one, (N,), and why it cannot be said."""
    from analysis.focusing.performance import aim
    from analysis.focusing.responses import responses
    from app.chain.models_ahead import silent
    from app.files.results.filter_files import load_focusing
    from app.stages.panel.laws import laws_for
    from app.twins.panel_twin import panel_twin

    lost = np.full(len(others), np.nan)
    try:
        panel, own, _ = load_focusing(run / FILTERS)
        laws = laws_for(run, None, "run").laws
        model = panel_twin(panel, laws, silent)
    except ResultFileError as error:
        return lost, str(error)
    lines, asked = panel.filters.frequency, model.space.asked(panel.target.displacement)
    band = panel.filters.in_band(lines)
    played: dict[float, tuple[EnergyForms, Complex]] = {}
    for row, other in enumerate(others):
        try:
            theirs = load_focusing(other / FILTERS)[1]
        except ResultFileError:
            continue
        same = (
            theirs.bank.sample_rate == own.bank.sample_rate and theirs.bank.taps.shape[1] == own.bank.taps.shape[1]
        )
        places = np.intersect1d(own.temperature, theirs.temperature)
        if not same or not places.size:
            continue
        places = places[
            np.unique(np.linspace(0, places.size - 1, min(places.size, MOST_TEMPERATURES)).astype(int))
        ]
        differences = []
        for here in places:
            if here not in played:
                ((constants, amplitude),) = responses(model, laws, np.array([here]), lines)
                forms = model.forms(*constants, lines, panel.target.displacement).at(slice(None), band)
                played[here] = (forms, amplitude[:, band])
            forms, amplitude = played[here]
            reached = [
                aim(
                    model.space,
                    forms,
                    amplitude,
                    one.bank.response(lines[band])[int(np.flatnonzero(one.temperature == here)[0])],
                    asked,
                )[0].mean()
                for one in (own, theirs)
            ]
            differences.append(reached[0] - reached[1])
        lost[row] = float(np.mean(differences))
    return lost, ""
