"""What is asked of the focus stage, and the task that follows from it: laws, panel and temperatures read."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from analysis.focusing.methods import Method
from analysis.focusing.panel import Panel
from analysis.progress import Progress
from app.files.bad_file import UnsuitedOptionError
from app.stages.panel.inputs import PanelTask, panel_of, require_aim
from app.stages.panel.laws import laws_for, range_of, said_of_range, within

if TYPE_CHECKING:
    from app.stages.focus import FocusedPanel


@dataclass(frozen=True, kw_only=True)
class FocusTask(PanelTask):
    """What `FocusRequest` came to.

    Attributes
    ----------
    panel : Panel
        With what was found about its plate.
    compute : callable
        Designs the filters; called with a progress callable. The focus stage is imported when it is called.
    """

    panel: Panel
    compute: Callable[[Progress], "FocusedPanel"]


@dataclass(frozen=True)
class FocusRequest:
    """Filters of a panel over temperature, as typed or declared.

    Attributes
    ----------
    run : Path or None
        Run folder or laws file; None for the current folder.
    twin : Path or None
        Twin file whose laws are taken.
    panel : Path or None
        Panel file; None for the paper's section 2.
    changes : mapping
        Filter settings that replace those of the panel, by key; None leaves one as it is.
    method : str
        How filters are designed.
    temperatures : tuple of float
        Degrees Celsius; empty for the stage's own.
    transfers : Path or None
        Measured transfers in place of laws and a twin.
    """

    run: Path | None
    twin: Path | None = None
    panel: Path | None = None
    changes: Mapping[str, Any] = field(default_factory=dict)
    method: Method = "stif"
    temperatures: tuple[float, ...] = ()
    transfers: Path | None = None

    def task(self) -> FocusTask:
        """Read laws or transfers, and the panel; ResultFileError where they do not suit what is asked."""
        return self._from_laws() if self.transfers is None else self._from_transfers(self.transfers)

    def _from_laws(self) -> FocusTask:
        declared, panel_path = panel_of(self.panel, self.changes)
        require_aim(declared, self.method)
        found = laws_for(self.run, self.twin, "focus")
        low, high = range_of(declared, found.laws, found.path, found.extent)
        named = None
        if self.temperatures:
            named = within(np.array(sorted(set(self.temperatures))), found.laws, found.path)
        panel, notes = found.on(declared)
        notes += said_of_range(panel, (low, high)) if named is None else []
        uncorrected = found.without_effects(np.array([low, high]) if named is None else named)

        def compute(report: Progress) -> "FocusedPanel":
            from app.stages import focus  # slow import, after all that is read was found good

            return focus.compute(
                panel, found.laws, report, temperature=named, method=self.method, uncorrected=uncorrected
            )

        return FocusTask(
            panel=panel,
            compute=compute,
            inputs=(found.path, panel_path),
            beside=found.folder,
            notes=notes,
            extent=found.extent,
            laws=found,
        )

    def _from_transfers(self, transfers: Path) -> FocusTask:
        from app.files.results.transfers_file import transfer_files
        from app.stages.panel.inputs import measured_panel

        declared, panel_path = panel_of(self.panel, self.changes)
        require_aim(declared, self.method)
        if self.method == "modal-control":
            raise UnsuitedOptionError("--method modal-control needs the modes of a model; --transfers has none")
        measured = measured_panel(declared, transfers, self.temperatures)

        from app.stages import focus

        compute = partial(focus.compute_measured, measured, method=self.method)
        return FocusTask(
            panel=declared,
            compute=compute,
            inputs=(*transfer_files(transfers), panel_path),
            beside=transfers.parent,
            notes=[],
        )
