"""Material laws of a panel's plate, and their common temperature range with the panel."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np

from analysis.arrays import Real
from analysis.focusing.panel import Panel
from analysis.focusing.responses import covered
from analysis.material import Material, MaterialLaws, MaterialSigma
from analysis.recordings.campaign import CampaignExtent
from app.files.bad_file import ResultFileError
from app.files.campaigns.inputs import origin_of_result, said_of_more_sweeps
from app.files.results.best_twin import CORRECTED, best_twin, recordings
from app.files.results.laws_elsewhere import laws_elsewhere
from app.files.results.laws_file import effects_in_laws, load_laws
from app.files.results.twin_file import TwinFile, inputs_digest, read_twin
from app.stages.panel.measured_plate import MeasuredPlate

OWN_SIGMA_SHARE = 0.1
"""Share of a twin file's sigma that each temperature has for itself: a twin file states the whole only, and what
the declaration leaves open, which all temperatures share, is nine tenths of it and more."""


LawsKind = Literal["run", "file", "twin"]


@dataclass(frozen=True)
class PanelLaws:
    """Laws that a panel's plate obeys.

    Attributes
    ----------
    path : Path
        File they stand in.
    laws : MaterialLaws
    folder : Path
        For results.
    notes : tuple of str
        Where they come from, as far as a user has to know it.
    measured : MeasuredPlate or None
        The plate that they were found on; None where only the laws are known.
    uncorrected : MaterialLaws or None
        Those of the plain twin, where `laws` are corrected.
    extent : CampaignExtent or None
        Of the campaign they were found in, where that was not complete.
    kind : str
        ``run``: the best twin of a run folder; ``file`` of laws; ``twin`` file.
    """

    path: Path
    laws: MaterialLaws
    folder: Path
    notes: tuple[str, ...] = ()
    measured: MeasuredPlate | None = None
    uncorrected: MaterialLaws | None = None
    extent: CampaignExtent | None = None
    kind: LawsKind = "run"

    def on(self, panel: Panel) -> tuple[Panel, list[str]]:
        """Return a panel with what was found about its plate, and all notes; ResultFileError if it cannot be."""
        if self.measured is None:
            return panel, list(self.notes)
        try:
            found, notes = self.measured.on(panel)
        except ValueError as error:
            raise ResultFileError(
                f"{self.path}: the plate as it was found cannot carry the panel: {error}; declare another plate"
            ) from error
        return found, [*self.notes, *notes]

    def without_effects(self, temperature: Real) -> MaterialLaws | None:
        """Return the uncorrected laws if they cover temperatures (T,), degrees Celsius."""
        if self.uncorrected is None:
            return None
        low, high = self.uncorrected.temperature_range
        there = low - 1e-9 <= temperature.min() and temperature.max() <= high + 1e-9
        return self.uncorrected if there else None


def laws_for(run: Path | None, twin: Path | None, verb: str) -> PanelLaws:
    """Return the laws of a run's best twin, of a laws file, or of a twin file if one is named.

    Parameters
    ----------
    run : Path or None
        Run folder, or a file of laws; None for the current folder.
    twin : Path or None
        Twin file.
    verb : str
        Name of the calling command, for messages.

    Returns
    -------
    PanelLaws
        Results go into the folder of the laws; with a twin file, or where the folder's laws are elsewhere, into
        `run`, if that is a folder.

    Raises
    ------
    ResultFileError
        Where there are no laws.
    """
    if twin is not None:
        return _of_twin(run, twin)
    run = run or Path()
    if run.is_file():
        return _of_file(run)
    elsewhere = laws_elsewhere(run)
    if elsewhere is not None:
        if elsewhere.twin is not None:
            return _of_twin(run, elsewhere.twin)
        return replace(laws_for(elsewhere.laws, None, verb), folder=run.resolve())
    best = best_twin(run, verb)
    path = best.twin.path.resolve()
    laws = load_laws(path) if best.twin.laws is None else best.twin.laws  # which says why there are none
    plain = None if best.uncorrected is None else best.uncorrected.laws
    extent, said = origin_of(path)
    notes = (*best.notes, *said)
    return PanelLaws(path, laws, path.parent, notes, MeasuredPlate.of_run(run, best), plain, extent)


def origin_of(path: Path) -> tuple[CampaignExtent | None, list[str]]:
    """Return how complete the campaign was in which laws were found, and notes on that; none where it was.

    Parameters
    ----------
    path : Path
        File of the laws.

    Returns
    -------
    extent : CampaignExtent or None
    notes : list of str

    Raises
    ------
    ResultFileError
        Where the file cannot be read.
    """
    verb = "gap" if path.name == CORRECTED else "update"
    origin = origin_of_result(path, verb)
    more = said_of_more_sweeps(path.parent, origin.inputs, verb)
    if more is not None:
        return origin.extent, [f"{path.name}: {more}"]
    return origin.extent, [] if origin.extent is None else [f"{path.name}: {origin.extent.note}"]


def _of_file(path: Path) -> PanelLaws:
    path = path.resolve()
    laws, beside = load_laws(path), path.with_name(CORRECTED)
    notes: tuple[str, ...] = ()
    if path.name != CORRECTED and beside.is_file() and not effects_in_laws(path):
        notes = (
            f"{path.name} is named itself: its laws are uncorrected; name the folder for those of the best twin",
        )
    extent, said = origin_of(path)
    return PanelLaws(path, laws, path.parent, (*notes, *said), extent=extent, kind="file")


def _of_twin(run: Path | None, twin: Path) -> PanelLaws:
    path, read = twin.resolve(), read_twin(twin)
    extent, said = _origin_of_twin(path, read)
    folder = run if run is not None and run.is_dir() else path.parent
    measured = MeasuredPlate.of_twin(read)
    corrected = (f"{twin}: the panel's plate obeys the corrected laws",) if read.effect else ()
    laws, plain = laws_of_twin(read, path), uncorrected_laws(folder)
    return PanelLaws(path, laws, folder, (*corrected, *said), measured, plain, extent, "twin")


def _origin_of_twin(path: Path, twin: TwinFile) -> tuple[CampaignExtent | None, list[str]]:
    """Return how complete a twin file's campaign was, and notes; gap.h5 of the same comparison says so."""
    beside = path.with_name("gap.h5")
    try:
        origin = origin_of_result(beside, "gap") if beside.is_file() else None
    except ResultFileError:  # the twin file does without
        return None, []
    if origin is None or twin.origin.inputs != inputs_digest(recordings(origin.inputs)):
        return None, []
    more = said_of_more_sweeps(path.parent, origin.inputs, "gap")
    if more is not None:
        return origin.extent, [f"{path.name}: {more}"]
    return origin.extent, [] if origin.extent is None else [f"{path.name}: {origin.extent.note}"]


def laws_of_twin(twin: TwinFile, origin: Path) -> MaterialLaws:
    """Smooth laws through the nodes of a twin file; ResultFileError for fewer than three."""
    from analysis.updating.laws import fit_laws

    nodes = twin.laws
    values = (nodes.youngs_modulus, nodes.poisson_ratio, nodes.loss_factor)
    spread = (nodes.sigma_youngs_modulus, nodes.sigma_poisson_ratio, nodes.sigma_loss_factor)
    try:
        material, sigma = Material(*map(np.array, values)), MaterialSigma(*map(np.array, spread))
        common = None
        if twin.departure:
            whole = (sigma.youngs_modulus / material.youngs_modulus, sigma.poisson_ratio)
            columns = np.stack([*whole, sigma.loss_factor / material.loss_factor], axis=1)
            common = np.sqrt(1.0 - OWN_SIGMA_SHARE**2) * columns[:, :, None]
            sigma = MaterialSigma(
                *(OWN_SIGMA_SHARE * x for x in (sigma.youngs_modulus, sigma.poisson_ratio, sigma.loss_factor))
            )
        span = nodes.temperature_range
        return fit_laws(np.array(nodes.temperature), material, sigma, temperature_range=span, common=common)
    except ValueError as error:
        raise ResultFileError(f"{origin}: laws: {error}") from error


def uncorrected_laws(run: Path) -> MaterialLaws | None:
    """Laws that `flexura update` wrote into a run.

    None if there are none, and if they were fitted with effects switched on (`flexura update --twin`), because
    those are corrected.
    """
    try:
        return None if effects_in_laws(run / "laws.h5") else load_laws(run / "laws.h5")
    except ResultFileError:
        return None


def range_of(
    panel: Panel, laws: MaterialLaws, origin: Path, extent: CampaignExtent | None = None
) -> tuple[float, float]:
    """Return the common temperature range of panel and laws.

    Parameters
    ----------
    origin : Path
        File of the laws, for messages.
    extent : CampaignExtent, optional
        Of their campaign, where that was not complete, for messages.

    Returns
    -------
    low, high : float
        Degrees Celsius.

    Raises
    ------
    ResultFileError
        If there is none.
    """
    try:
        return covered(laws, panel.filters.operating_range)
    except ValueError as error:
        of_part = "" if extent is None else f" (this one is not complete: {extent.said})"
        raise ResultFileError(f"{origin}: {error}; update a campaign that covers them{of_part}") from error


def said_of_range(panel: Panel, covered: tuple[float, float]) -> list[str]:
    """Return a note where laws that cover `covered`, °C, do not reach over all of the panel's operating range."""
    low, high = panel.filters.operating_range
    if covered == (low, high):
        return []
    return [
        f"the laws cover {covered[0]:g} to {covered[1]:g} °C only: no filters for the rest of the panel's "
        f"operating_range, {low:g} to {high:g} °C; update a campaign that covers it"
    ]


def within(temperature: Real, laws: MaterialLaws, origin: Path) -> Real:
    """Return temperatures after checking that the laws cover all of them.

    Parameters
    ----------
    temperature : (T,) ndarray
        Degrees Celsius.
    origin : Path
        File of the laws, for messages.

    Returns
    -------
    (T,) ndarray
        `temperature` itself.

    Raises
    ------
    ResultFileError
        If the laws do not cover one, which is named, or if `temperature` is empty.
    """
    if not temperature.size:
        raise ResultFileError(f"{origin}: no temperature is named; at least one is needed")
    low, high = laws.temperature_range
    outside = temperature[~np.isfinite(temperature) | (temperature < low - 1e-9) | (temperature > high + 1e-9)]
    if outside.size:
        raise ResultFileError(
            f"{origin}: --temperature {outside[0]:g} °C is outside the laws' range, {low:g} to {high:g} °C"
        )
    return temperature
