"""What is asked of the focus stage, and the task that follows from it: laws, panel and temperatures read.

What is asked of the compensate stage, and the task that follows from it: laws, panel and settings read.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from analysis.compensation.settings import FEWEST_TRAINING_TEMPERATURES, Training, suited_nodes
from analysis.focusing.methods import Method
from analysis.focusing.panel import Panel
from analysis.focusing.panel_model import spaced
from analysis.progress import Progress
from analysis.recordings.campaign import CampaignExtent
from app.files.bad_file import ResultFileError, UnsuitedOptionError
from app.stages.panel.inputs import (
    PanelTask,
    method_for,
    panel_for,
    panel_of,
    require_aim,
    require_same_filters,
    scanned_panel,
    weather_for,
)
from app.stages.panel.laws import laws_for, range_of, said_of_range, within

if TYPE_CHECKING:
    from app.stages.compensate import CompensatedPanel
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


@dataclass(frozen=True, kw_only=True)
class CompensateTask(PanelTask):
    """What `CompensateRequest` came to.

    Attributes
    ----------
    compute : callable
        Trains and compares; called with a progress callable and a device. The stage is imported when it is called.
    training : Training
        With the hidden nodes that suit the temperatures, unless they were chosen.
    panel : Panel
    method : str
        How its filters are designed.
    origin : Path
        File that the panel comes from.
    """

    compute: Callable[[Progress, str], "CompensatedPanel"]
    training: Training
    panel: Panel
    method: Method
    origin: Path

    def require_folder(self, folder: Path) -> None:
        """Refuse a folder that holds filters of another panel, see `require_same_filters`."""
        require_same_filters(folder, self.beside, self.panel, self.method, self.origin)


@dataclass(frozen=True)
class CompensateRequest:
    """Networks and other methods that follow a panel's filters, as typed or declared.

    Attributes
    ----------
    run : Path or None
        Run folder or laws file; None for the current folder.
    twin : Path or None
        Twin file whose laws are taken.
    panel : Path or None
        Panel file; None for that of the run's filters, else the paper's section 2.
    changes : mapping
        Filter settings that replace those of the panel, by key; None leaves one as it is.
    method : str or None
        How the filters are designed that are followed; None for the method of the run's filters, else STIF.
    spacing : float
        Between training temperatures, K.
    place : int or None
        Number of training temperatures placed by need, in place of `spacing`.
    across : tuple of float
        Differences between two sides of the panel, K.
    training : Training
    nodes_chosen : bool
        Whether the nodes of `training` were chosen: else fewer are taken where temperatures are few.
    transfers : Path or None
        Measured transfers in place of laws and a twin.
    weather : Path or None
        File of the weather in which filters are judged.
    """

    run: Path | None
    twin: Path | None = None
    panel: Path | None = None
    changes: Mapping[str, Any] = field(default_factory=dict)
    method: Method | None = None
    spacing: float = 5.0
    place: int | None = None
    across: tuple[float, ...] = ()
    training: Training = field(default_factory=Training)
    nodes_chosen: bool = False
    transfers: Path | None = None
    weather: Path | None = None

    def task(self) -> CompensateTask:
        """Read laws or transfers, and the panel; ResultFileError where they do not suit what is asked."""
        return self._from_laws() if self.transfers is None else self._from_transfers(self.transfers)

    def _from_laws(self) -> CompensateTask:
        found = laws_for(self.run, self.twin, "compensate")
        declared, panel_path = panel_for(self.panel, found.folder, self.changes)
        method = method_for(self.method, self.panel, found.folder)
        require_aim(declared, method)
        low, high = range_of(declared, found.laws, found.path, found.extent)
        self._check_temperatures((low, high), found.extent)
        panel, notes = found.on(declared)
        notes += said_of_range(panel, (low, high))
        training = self._training(None if self.place is None else suited_nodes(self.place))
        weather = None if self.weather is None else (weather_for(self.weather, panel, method), str(self.weather))

        def compute(report: Progress, device: str) -> "CompensatedPanel":
            from app.stages import compensate  # slow import, after all that is read was found good

            return compensate.compute(
                panel,
                found.laws,
                report,
                training=training,
                spacing=self.spacing,
                method=method,
                device=device,
                place=self.place,
                across=self.across,
                weather=weather,
            )

        return CompensateTask(
            compute=compute,
            training=training,
            inputs=(found.path, panel_path, *(() if self.weather is None else (self.weather,))),
            beside=found.folder,
            notes=notes,
            extent=found.extent,
            laws=found,
            panel=panel,
            method=method,
            origin=panel_path,
        )

    def _training(self, suited: int | None) -> Training:
        return self.training if suited is None or self.nodes_chosen else replace(self.training, nodes=suited)

    def _check_temperatures(self, span: tuple[float, float], extent: CampaignExtent | None) -> None:
        """Refuse a spacing, places or differences that the laws' range of temperatures does not allow."""
        from analysis.compensation.knots import check_places

        low, high = span
        of_part = "" if extent is None else f" (the campaign of the laws is not complete: {extent.said})"
        try:
            if self.place is None:
                self.training.check_temperatures(len(spaced(low, high, self.spacing)))
            else:
                check_places(self.place, low, high)
        except ValueError as error:
            option = f"--spacing {self.spacing:g}, {low:g} to {high:g} °C" if self.place is None else "--place"
            raise UnsuitedOptionError(f"{option}: {error}{of_part}") from error
        if self.across and max(self.across) > high - low:
            raise UnsuitedOptionError(
                f"--across {max(self.across):g} K: the laws hold from {low:g} to {high:g} °C, so that up to "
                f"{high - low:g} K can be judged{of_part}"
            )

    def _from_transfers(self, transfers: Path) -> CompensateTask:
        from app.files.results.transfers_file import transfer_files
        from app.stages.panel.inputs import measured_panel

        beside = self.run or transfers.parent
        declared, panel_path = scanned_panel(self.panel, beside, self.changes)
        method = method_for(self.method, self.panel, beside)
        require_aim(declared, method)
        if method == "modal-control":
            raise UnsuitedOptionError("--method modal-control needs the modes of a model; --transfers has none")
        measured = measured_panel(declared, transfers, ())
        count = len(measured.transfers.temperature)
        if count <= FEWEST_TRAINING_TEMPERATURES:
            raise ResultFileError(
                f"{transfers}: transfers at {count} temperatures; at least {FEWEST_TRAINING_TEMPERATURES + 1} are "
                "needed, to train on all but one: measure more, in one HDF5 file or a folder of "
                "universal files, one a temperature"
            )
        training = self._training(suited_nodes(count, measured=True))

        def compute(report: Progress, device: str) -> "CompensatedPanel":
            from app.stages import compensate

            return compensate.compute_measured(measured, report, training=training, method=method, device=device)

        return CompensateTask(
            compute=compute,
            training=training,
            inputs=(*transfer_files(transfers), panel_path),
            beside=beside,
            notes=[],
            panel=declared,
            method=method,
            origin=panel_path,
        )
