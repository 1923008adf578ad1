"""Filters of a panel that follow the temperature, the paper's figures, and what has changed since a baseline.

They take laws or a twin file, a panel or measured transfers, and a folder for their results.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path

import numpy as np

from analysis.compensation.settings import ACROSS, PLACES, SPACINGS, Training
from analysis.focusing.methods import METHODS, Method
from analysis.focusing.panel import Panel
from analysis.material import MaterialLaws
from analysis.recordings.campaign import CampaignExtent
from analysis.recordings.grid_frequency import require_mains
from app.files.declarations.panel import SECTION_2, read_panel
from app.files.provenance import sha256
from app.files.results.laws_file import remember_laws
from app.files.results.run_folder import writable_folder
from app.files.results.transfers_file import transfer_files
from app.stages import compensate as compensate_stage
from app.stages import focus as focus_stage
from app.stages import health as health_stage
from app.stages import study as study_stage
from app.stages.gap import GapComparison
from app.stages.panel.inputs import (
    checked_device,
    measured_panel,
    method_for,
    panel_for,
    require_same_filters,
    scanned_panel,
    weather_for,
)
from app.stages.panel.laws import PanelLaws, laws_for, range_of, within
from app.stages.update import Updating
from app.summaries import compensation as compensate_words
from app.summaries import focusing as focus_words
from app.summaries.update import too_few
from flexura.arguments import File, as_path, computing, numbers, require_range

Laws = File | MaterialLaws | Updating | GapComparison
"""A run folder, whose best twin is taken, or a file of laws; laws, or a result of `update` or `gap`."""


@dataclass(frozen=True)
class _GivenLaws:
    """Laws of a panel's plate, from a file or in memory.

    Attributes
    ----------
    laws : MaterialLaws
    read : PanelLaws or None
        What else their file says; None for laws in memory.
    """

    laws: MaterialLaws
    read: PanelLaws | None = None

    @property
    def path(self) -> Path | None:
        """File the laws stand in; None for laws in memory."""
        return None if self.read is None else self.read.path

    @property
    def folder(self) -> Path | None:
        """Where their filters may lie."""
        return None if self.read is None else self.read.folder

    @property
    def extent(self) -> CampaignExtent | None:
        """Of the campaign they were found in, where a file says that it was not complete."""
        return None if self.read is None else self.read.extent

    @property
    def origin(self) -> Path:
        """Return what messages name."""
        return self.path or Path("laws")

    def remember(self, folder: Path) -> None:
        """Write into a folder of results where their laws are, if they are elsewhere."""
        if self.read is not None:
            remember_laws(folder, self.read.path, kind=self.read.kind)

    def on(self, panel: Panel) -> tuple[Panel, list[str]]:
        """Return a panel with what was found about its plate, and notes, see `PanelLaws.on`."""
        return (panel, []) if self.read is None else self.read.on(panel)


def _laws_read(laws: Laws | None, twin: File | None, verb: str) -> _GivenLaws:
    """Read the laws that a panel's plate obeys.

    Parameters
    ----------
    laws : path, MaterialLaws, Updating or GapComparison, optional
    twin : path, optional
        Twin file, whose laws take the place of those.
    verb : str
        Of the command that does the same, for messages.

    Raises
    ------
    ValueError
        For neither laws nor twin, laws in memory beside a twin, and a result without laws.
    """
    if twin is None and laws is None:
        raise ValueError("laws, twin or transfers: one of them is needed")
    if isinstance(laws, MaterialLaws | Updating | GapComparison):
        if twin is not None:
            raise ValueError(
                "twin takes the place of laws in memory: leave laws out, or name the run folder there"
            )
        if isinstance(laws, MaterialLaws):
            return _GivenLaws(laws)
        found = laws.corrected.laws if isinstance(laws, GapComparison) else laws.laws
        if found is None:
            of = laws.plain if isinstance(laws, GapComparison) else laws
            raise ValueError(too_few(of.updated))
        return _GivenLaws(found)
    read = laws_for(_path_of(laws), _path_of(twin), verb)
    return _GivenLaws(read.laws, read)


def _panel_followed(
    panel: File | Panel | None, method: Method | None, folder: Path | None, *, scanned: bool = False
) -> tuple[Panel, Path | None, Method]:
    """Choose panel and method of the filters that networks follow, as the verb does.

    Parameters
    ----------
    panel : path or Panel, optional
    method : str, optional
    folder : Path or None
        Run folder whose filters say what is left out.
    scanned : bool
        Whether the panel's transfers are measured: filters in `folder` may then come from transfers, too.

    Returns
    -------
    panel : Panel
    path : Path or None
        Its file; None for a panel in memory.
    method : str

    Raises
    ------
    ResultFileError
        For a panel that cannot be read, and for filters in `folder` that were designed from measured transfers
        where the panel is not `scanned`.
    """
    if isinstance(panel, Panel):
        return panel, None, method or "stif"
    named = _path_of(panel)
    if folder is None:
        file = named or SECTION_2
        return read_panel(file), file, method or "stif"
    choose = scanned_panel if scanned else panel_for
    return *choose(named, folder, {}), method_for(method, named, folder)


def _folder_of(run: Laws | None, transfers: Path) -> Path:
    """Run folder of the filters that were designed from transfers; that of the transfers where none is named."""
    if run is None:
        return transfers.parent
    if isinstance(run, MaterialLaws | Updating | GapComparison) or not as_path(run).is_dir():
        raise ValueError("laws beside transfers: the run folder of flexura focus --transfers, or leave it out")
    return as_path(run)


def _kept(out: File | None, laws: Path | None, panel: Path | None) -> tuple[Path | None, Mapping[str, str]]:
    """Make the run folder for results that are to be written.

    Parameters
    ----------
    out : path, optional
    laws, panel : Path or None
        Files the results follow from; measured transfers, a file or a folder, count as laws.

    Returns
    -------
    folder : Path or None
        None where nothing is to be written.
    inputs : mapping
        SHA-256 of each file, by name.

    Raises
    ------
    ValueError
        For laws or a panel that are in no file.
    """
    if out is None:
        return None, {}
    if laws is None or panel is None:
        raise ValueError(
            "out keeps the SHA-256 of the files that filters follow from: name the run folder that holds laws.h5 "
            "in place of laws, and the panel's file in place of a panel"
        )
    files = (*transfer_files(laws), panel)
    return writable_folder(as_path(out), "out"), {path.name: sha256(path) for path in files}


def _path_of(file: File | None) -> Path | None:
    """Path of a file, if one is named."""
    return None if file is None else as_path(file)


def focus(
    laws: Laws | None = None,
    panel: File | Panel = SECTION_2,
    *,
    transfers: File | None = None,
    twin: File | None = None,
    temperature: float | Sequence[float] | None = None,
    method: Method = "stif",
    out: File | None = None,
    progress: bool | None = None,
) -> focus_stage.FocusedPanel:
    """Design filters of a panel over temperature, as ``flexura focus``.

    Parameters
    ----------
    laws : path, MaterialLaws, Updating or GapComparison
        Which the panel's plate obeys. Of a run folder those of its best twin: corrected, where ``flexura gap``
        named an effect. Beside `twin` a run folder, or left out.
    panel : path or Panel
        The paper's section 2 where it is left out.
    transfers : path, optional
        Measured transfers (UFF58 with nodes, a folder of such, or HDF5) in place of laws and the panel's twin.
    twin : path, optional
        Twin file whose laws the panel's plate obeys, in place of those of the run folder.
    temperature : float or sequence of float, optional
        Degrees Celsius; every 5 K of what laws and panel share where it is left out. Of `transfers` in a universal
        file, the one at which they were measured.
    method : str
        How filters are designed: ``stif``, ``time-reversal``, ``modal-control`` or ``none``.
    out : path, optional
        Run folder for filters.h5; wants laws and panel as paths, whose SHA-256 the file keeps. Nothing is written
        where it is left out.
    progress : bool, optional
        Draw progress bars on the error stream, where that is a terminal, or in a notebook; None: in a notebook.

    Raises
    ------
    ValueError
        For an unknown method, a method that `transfers` do not serve, laws beside `transfers` or in memory beside
        `twin`, and for `out` with laws or a panel that are in no file.
    app.files.bad_file.ResultFileError
        For a file that cannot be used, a temperature outside the laws' range, and laws that share no temperatures
        with the panel.
    app.files.campaign_error.CampaignFileError
        For a twin file that cannot be used.
    """
    _require_method(method)
    file = None if isinstance(panel, Panel) else as_path(panel)
    declared = panel if isinstance(panel, Panel) else read_panel(as_path(panel))
    extent, given = None, None
    if transfers is not None:
        _require_none(laws=laws, twin=twin)
        named = () if temperature is None else numbers(temperature)
        measured = measured_panel(declared, as_path(transfers), named)
        run, inputs = _kept(out, as_path(transfers), file)
        with computing(shown=progress) as report:
            found = focus_stage.compute_measured(measured, report, method=method)
    else:
        given = _laws_read(laws, twin, "focus")
        extent = given.extent
        run, inputs = _kept(out, given.path, file)
        span, wanted = np.array(range_of(declared, given.laws, given.origin, extent)), None
        if temperature is not None:
            span = wanted = within(np.unique(np.asarray(temperature, float)), given.laws, given.origin)
        without = None if given.read is None else given.read.without_effects(span)
        declared, notes = given.on(declared)
        with computing(shown=progress) as report:
            found = focus_stage.compute(
                declared,
                given.laws,
                report,
                temperature=wanted,
                method=method,
                uncorrected=without,
                notes=notes,
            )
    if run is not None:
        focus_stage.save(run, found, inputs, extent)
        if given is not None:
            given.remember(run)
    said = (*focus_words.notes(found.panel, found.focusing), *focus_words.tradeoff(found.panel, found.pareto))
    worth = focus_words.correction(found.focusing, found.uncorrected)
    return replace(found, notes=(*said, *found.notes, *worth))


def compensate(
    laws: Laws | None = None,
    panel: File | Panel | None = None,
    *,
    transfers: File | None = None,
    twin: File | None = None,
    training: Training | None = None,
    spacing: float | None = None,
    place: int | None = None,
    across: float | Sequence[float] = (),
    weather: File | None = None,
    method: Method | None = None,
    device: str = "cpu",
    out: File | None = None,
    progress: bool | None = None,
) -> compensate_stage.CompensatedPanel:
    """Train networks that give filters at any temperature, and judge them and their rivals.

    As ``flexura compensate``.

    Parameters
    ----------
    laws : path, MaterialLaws, Updating or GapComparison
        Which the panel's plate obeys, as for `focus`. Beside `twin` a run folder, or left out; beside `transfers`
        the run folder of their filters, or left out.
    panel : path or Panel, optional
        That of filters.h5 beside the laws or the transfers where it is left out, else the paper's section 2.
    transfers : path, optional
        Measured transfers at five temperatures or more (HDF5, a folder of UFF58), in place of laws and the
        panel's twin.
    twin : path, optional
        Twin file whose laws the panel's plate obeys.
    training : Training, optional
        Standard settings where it is left out, with fewer hidden nodes for few temperatures placed or measured.
    spacing : float, optional
        Between training temperatures, K; 5 where it is left out.
    place : int, optional
        How many training temperatures are placed where the filters need them, instead of every `spacing`.
    across : float or sequence of float
        Differences of temperature between two opposite sides of the panel, K, at which the filters are tried.
    weather : path, optional
        A weather's file: the panel's field of temperatures moves as it says, and filters are judged by what is
        known of it.
    method : str, optional
        How the filters are designed that are followed; as those of filters.h5 whose panel is taken where it is
        left out, else ``stif``.
    device : str
        Where networks are trained: ``cpu``, or a device of torch, ``cuda``, ``cuda:1``.
    out : path, optional
        Run folder for compensation.h5; wants laws and panel as paths, whose SHA-256 the file keeps. Nothing is
        written where it is left out.
    progress : bool, optional
        Draw progress bars on the error stream, where that is a terminal, or in a notebook; None: in a notebook.

    Raises
    ------
    analysis.compensation.evidence_collapse.EvidenceCollapseError
        Where a network is refused.
    ValueError
        For an unknown method, temperatures that cannot be chosen so, fewer than five measured, laws in memory
        beside `twin` or `transfers`, and for `out` with laws or a panel that are in no file.
    app.files.bad_file.ResultFileError
        For a file that cannot be used, a device that torch cannot use, and laws that share no temperatures with
        the panel.
    app.files.campaign_error.CampaignFileError
        For a twin file or a weather that cannot be used.
    """
    if method is not None:
        _require_method(method)
    require_range("spacing", () if spacing is None else (spacing,), *SPACINGS, " K")
    require_range("place", () if place is None else (place,), *PLACES)
    require_range("across", numbers(across), *ACROSS, " K")
    extent, given = None, None
    if transfers is not None:
        _require_none(twin=twin, spacing=spacing, place=place, across=numbers(across) or None, weather=weather)
        scan, beside = as_path(transfers), _folder_of(laws, as_path(transfers))
        declared, file, followed = _panel_followed(panel, method, beside, scanned=True)
        measured = measured_panel(declared, scan, ())
        _require_folder(out, beside, declared, followed, file)
        run, inputs = _kept(out, scan, file)
        checked_device(device)
        with computing(shown=progress) as report:
            found = compensate_stage.compute_measured(
                measured, report, training=training, method=followed, device=device
            )
    else:
        given = _laws_read(laws, twin, "compensate")
        extent = given.extent
        declared, file, followed = _panel_followed(panel, method, given.folder)
        range_of(declared, given.laws, given.origin, extent)
        on_plate, notes = given.on(declared)
        _require_folder(out, given.folder, on_plate, followed, file)
        run, inputs = _kept(out, given.path, file)
        declared = on_plate
        around = None
        if weather is not None:
            around = weather_for(as_path(weather), declared, followed), str(weather)
            inputs = {**inputs, as_path(weather).name: sha256(as_path(weather))} if inputs else inputs
        checked_device(device)
        with computing(shown=progress) as report:
            found = compensate_stage.compute(
                declared,
                given.laws,
                report,
                training=training,
                spacing=spacing or 5.0,
                place=place,
                across=numbers(across),
                weather=around,
                method=followed,
                device=device,
                notes=notes,
            )
    if run is not None:
        compensate_stage.save(run, found, inputs, extent)
        if given is not None:
            given.remember(run)
    said = compensate_words.notes(found.compensation, training or Training())
    return replace(found, notes=(*found.notes, *said))


def _require_folder(
    out: File | None, beside: Path | None, panel: Panel, method: Method, file: Path | None
) -> None:
    """Refuse a folder with filters of another panel; laws or a panel of no file are refused for that."""
    if out is not None and beside is not None and file is not None:
        require_same_filters(as_path(out), beside, panel, method, file)


def _require_none(**options: object) -> None:
    for name, value in options.items():
        if value is not None:
            raise ValueError(f"transfers take the place of {name}: leave one of them out")


def _require_method(method: str) -> None:
    if method not in METHODS:
        raise ValueError(f"method {method!r}: {' or '.join(METHODS)}")


def health(
    dates: File | Sequence[File],
    baseline: File,
    *,
    rate: float = health_stage.FALSE_ALARM_RATE,
    mains: float = 50.0,
    out: File | None = None,
    progress: bool | None = None,
) -> health_stage.WatchedPanel:
    """Say what has changed on a panel since its baseline, as ``flexura health``.

    Parameters
    ----------
    dates : path or sequence of path
        In order of time: run folders with frf.h5, or campaign folders.
    baseline : path
        Run folder of ``flexura update``, of the panel when it was healthy.
    rate : float
        False alarms per date, at most: 1e-9 to 0.1.
    mains : float
        Hz; for dates that are campaign folders.
    out : path, optional
        Folder for health.json; nothing is written where it is left out.
    progress : bool, optional
        Draw progress bars on the error stream, where that is a terminal, or in a notebook; None: in a notebook.

    Raises
    ------
    app.files.bad_file.ResultFileError, app.files.campaign_error.CampaignFileError
        For a rate outside what is allowed, no dates, a baseline that is none, a date of another panel, and what
        cannot be read.
    """
    require_mains(mains)
    those = [dates] if isinstance(dates, str | PathLike) else dates
    request = health_stage.HealthRequest(
        baseline=as_path(baseline), dates=tuple(as_path(one) for one in those), rate=rate, mains=mains
    )
    folder = None if out is None else writable_folder(as_path(out), "out")
    with computing(shown=progress) as report:
        found = health_stage.compute(request, report)
    if folder is not None:
        health_stage.save(folder, found)
    return found


def study(
    figure: str | int,
    run: File | None = None,
    *,
    panel: File | None = None,
    as_paper: bool = False,
    seed: int = 0,
    out: File | None = None,
    progress: bool | None = None,
) -> study_stage.StudiedPanel:
    """Compute a figure of the paper on focusing, or all, for a panel, as ``flexura study``.

    Parameters
    ----------
    figure : str or int
        4, 13 to 19, or ``all``.
    run : path, optional
        Run folder with laws; the current folder where it is left out.
    panel : path, optional
        Panel file; that of the run's filters.h5 where it is left out.
    as_paper : bool
        Whether networks are fed, scaled, started and split, and filters designed, as in the paper.
    seed : int
        Of all that is random.
    out : path, optional
        Folder for studies.h5; nothing is written where it is left out.
    progress : bool, optional
        Draw progress bars on the error stream, where that is a terminal, or in a notebook; None: in a notebook.

    Raises
    ------
    analysis.compensation.evidence_collapse.EvidenceCollapseError
        Where the networks are refused.
    app.files.bad_file.ResultFileError, app.files.campaign_error.CampaignFileError
        For a figure that the paper does not have, and laws and panels that cannot be used.
    """
    request = study_stage.StudyRequest(
        figure=str(figure),
        run=None if run is None else as_path(run),
        panel=None if panel is None else as_path(panel),
        as_paper=as_paper,
        seed=seed,
    )
    with computing(shown=progress) as report:
        return study_stage.compute(request, None if out is None else as_path(out), report)
