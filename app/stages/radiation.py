"""Radiation stage: the sound of a panel with the filters of a run, computed and saved."""

import json
import time
from contextlib import nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from analysis.focusing.panel import Panel
from analysis.progress import Progress
from analysis.recordings.campaign import CampaignExtent
from app.files.bad_file import ResultFileError, UnsuitedOptionError
from app.files.campaigns.inputs import extent_settings
from app.files.declarations.panel import panel_of_text, read_panel
from app.files.provenance import provenance, sha256
from app.files.results.panel_files import load_focusing
from app.files.results.run_folder import run_file, run_folder
from app.files.results.transfers_file import transfer_files
from app.stages.panel.inputs import measured_panel
from app.stages.panel.laws import laws_for
from app.summaries.numbers import extent_record, led

if TYPE_CHECKING:  # a run is told to be of another kind before what computes is imported
    from analysis.focusing.radiated import Radiation

RADIATION = "radiation.h5"


@dataclass(frozen=True, kw_only=True)
class RadiationRequest:
    """Filters whose sound is computed, as typed or declared.

    Attributes
    ----------
    run : Path
        Run folder with filters.h5, or that file.
    panel : Path or None
        Panel file whose ``[sound]`` is taken; None for the filters' own.
    transfers : Path or None
        Measured transfers, from which the filters were made, in place of laws and a twin.
    twin : Path or None
        Twin file whose laws are taken.
    """

    run: Path
    panel: Path | None = None
    transfers: Path | None = None
    twin: Path | None = None

    def __post_init__(self) -> None:
        """Raise UnsuitedOptionError for options that exclude each other."""
        if self.transfers is not None and self.twin is not None:
            raise UnsuitedOptionError("--transfers takes the place of laws and of --twin: leave one of them out")

    @property
    def filters(self) -> Path:
        """The file of filters; ResultFileError where the run folder has none."""
        return self.run if self.run.is_file() else run_file(self.run, "filters.h5", "radiation")


@dataclass(frozen=True)
class RadiatingPanel:
    """Result of the radiation stage.

    Attributes
    ----------
    panel : Panel
        With the listeners, air and mounting that were computed.
    radiation : Radiation
    file : Path or None
        radiation.h5; None where nothing was written.
    seconds : float
        It took.
    extent : CampaignExtent or None
        Of the campaign that the laws come from.
    notes : tuple of str
        For people.
    """

    panel: Panel
    radiation: "Radiation"
    file: Path | None
    seconds: float
    extent: CampaignExtent | None = None
    notes: tuple[str, ...] = field(default=(), repr=False)

    def record(self) -> dict[str, Any]:
        """Return what ``--json`` prints."""
        from app.summaries.radiation import record

        return record(self.panel, self.radiation, self.seconds) | extent_record(self.extent)

    def __repr__(self) -> str:
        """Say in one line what is heard."""
        from app.summaries.radiation import summary

        return f"{led(self.extent)}{summary(self.panel, self.radiation, self.file, self.seconds)}"


def compute(request: RadiationRequest, out: Path | None, report: Progress) -> RadiatingPanel:
    """Compute the sound of a panel, and write radiation.h5 where a folder is named for it.

    Parameters
    ----------
    out : Path or None
        Folder for the file.
    report : callable
        Called with a stage's name and the share of it done.

    Raises
    ------
    ResultFileError, CampaignFileError
        For files that cannot be used, a grid or points too coarse for the wavelength, laws that leave the panel's
        twin, and transfers at other temperatures than the filters.
    """
    started = time.perf_counter()
    run, filters = request.run, request.filters
    declared, focusing, _ = load_focusing(filters)
    inputs = {filters.name: sha256(filters)}
    if request.panel is not None:
        declared, inputs[request.panel.name] = _with_sound(declared, request.panel), sha256(request.panel)
    origin = measured = None
    if request.transfers is None:
        origin = laws_for(run, request.twin, "radiation")
        inputs[origin.path.name] = sha256(origin.path)
    else:
        measured = measured_panel(declared, request.transfers, ())
        inputs |= {path.name: sha256(path) for path in transfer_files(request.transfers)}

    from analysis.focusing.radiated import radiate, radiate_measured
    from app.files.results.panel_files import save_radiation
    from app.summaries.radiation import notes
    from app.twins.panel_twin import panel_twin

    reference, extent = focusing.reference_temperature, None if origin is None else origin.extent
    with nullcontext() if out is None else run_folder(filters.parent, out):
        try:
            if measured is not None:
                found = radiate_measured(measured, focusing.bank, reference, report)
            elif origin is not None:
                laws = declared.plate.grown(origin.laws)
                model = panel_twin(declared, laws, report)
                found = radiate(model, declared, laws, focusing.bank, reference, report)
        except ValueError as error:
            about = "panel's grid" if measured is None else "measured transfers"
            raise ResultFileError(f"the {about}: {error}") from error
        settings = {"panel": declared.model_dump(mode="json"), **extent_settings(extent)}
        file = None if out is None else out / RADIATION
        if file is not None:
            save_radiation(file, declared, found, provenance(inputs, settings))
    said = (*(() if origin is None else origin.notes), *notes(declared, found))
    return RadiatingPanel(declared, found, file, time.perf_counter() - started, extent, said)


def _with_sound(panel: Panel, path: Path) -> Panel:
    """Return a panel with the listeners, air and mounting of another panel's file.

    Raises
    ------
    ResultFileError
        Where the file cannot be read, or lacks listeners of the zone that the filters play to.
    """
    sound = read_panel(path).sound.model_dump(mode="json")
    return panel_of_text(json.dumps(panel.model_dump(mode="json") | {"sound": sound}), str(path))
