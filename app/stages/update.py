"""Update stage: model updating of a campaign, with or without effects, computed and saved."""

from dataclasses import KW_ONLY, dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.declaration.plate_material import PlateMaterial
from analysis.forked import ForkedExecutor
from analysis.gap.data.preparation import sweep_points
from analysis.labelled import Labelled, LabelledArrays
from analysis.material import LocalLaws, MaterialLaws, Orthotropy
from analysis.pairing.assignment import Pairing
from analysis.progress import Progress
from analysis.protocol.objections import unresolved
from analysis.recordings.frf import Frf, campaign_frf
from analysis.recordings.frf_campaign import AnyCampaign
from analysis.recordings.grid_frequency import require_mains
from analysis.recordings.sweep_point import SweepPoint
from analysis.twin_model import Effects, HeldEffects, TwinModel
from analysis.updated import Updated
from analysis.updating.corrected_twin import corrected_twin, fit_twin
from analysis.updating.drift import sweep_laws, to_first_order
from analysis.updating.laws import laws_of_sweeps
from analysis.updating.sheet_start import sheet_start
from analysis.updating.start import require_bending
from analysis.updating.update import outlier_sweeps, polarity_corrected, update
from app.files.campaigns.inputs import campaign_settings
from app.files.provenance import provenance, sha256
from app.files.results.laws_file import TwinFrf, save_laws
from app.files.results.modes_file import save_frf
from app.files.results.pairing_json import pairing_record
from app.stages.comparison.pairing import (
    MeasuredSweeps,
    measured_sweeps,
    paired_sweeps,
    said_of_older_modes,
    with_reason,
)
from app.stages.comparison.temperature_notes import drift_notes, label_notes, recorded_notes
from app.summaries.modes import pairing_tables
from app.summaries.table import as_html, as_text
from app.summaries.update import gain_notes, headline, notes, tables_of
from app.twins.campaign_twin import (
    Start,
    campaign_model,
    campaign_twin,
    judging,
    placed,
    start_of,
    tolerant_twin,
    twin_is_built,
)
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.twin import Twin


@dataclass(frozen=True)
class UpdateRequest:
    """Model updating of a campaign's twin; its files are read and checked when it is made.

    Attributes
    ----------
    campaign : AnyCampaign
    twin : Path or None
        Twin file whose effects are on: held by the update stage, where the gap stage begins.
    effects : Path or None
        Folder with a user's own effects.
    mains : float
        Hz.

    Raises
    ------
    CampaignFileError, ResultFileError
        For a twin file or effects that do not suit the campaign's plate.
    ValueError
        For a mains frequency outside its range.
    """

    campaign: AnyCampaign
    _: KW_ONLY
    twin: Path | None = None
    effects: Path | None = None
    mains: float = 50.0

    def __post_init__(self) -> None:
        require_mains(self.mains)
        _ = self.start

    @cached_property
    def start(self) -> Start | None:
        """The twin file as read; None where none is named."""
        return start_of(self.twin, self.campaign.experiment, self.effects)

    def origin(self) -> dict[str, Any]:
        """Return the provenance of results."""
        named: dict[str, Any] = {"mains": self.mains}
        if self.start is not None:
            named |= {"twin": sha256(self.start.path), "effects": self.start.twin.effects}
        return provenance(self.campaign.hashes, named | campaign_settings(self.campaign))


@dataclass(frozen=True)
class Updating(Labelled):
    """Result of the update stage.

    Attributes
    ----------
    frf : Frf
        FRFs as fitted: signs of inverted channels corrected, outlier sweeps left out.
    updated : Updated
        Estimates per sweep.
    laws : MaterialLaws or None
        Smooth laws through the estimates; None for fewer than three temperatures.
    twin : TwinFrf
        FRFs of the updated twin.
    measured : MeasuredSweeps or None
        Modes of some sweeps; None where none can be identified.
    pairing : Pairing or None
        Of these with the twin's; None where either is not known.
    """

    frf: Frf
    updated: Updated
    laws: MaterialLaws | None
    twin: TwinFrf
    measured: MeasuredSweeps | None = None
    pairing: Pairing | None = None

    def labelled(self) -> LabelledArrays:
        """Estimates over sweep, see `Updated.labelled`."""
        return self.updated.labelled()

    def __repr__(self) -> str:
        """Sweeps, ranges of E, nu and eta, and misfit in one line, and the notes."""
        return as_text(f"Updating: {headline(self.updated)}", self._notes)

    def _repr_html_(self) -> str:
        record = pairing_record(self.pairing)
        tables = [*tables_of(self.updated, self.frf.drives), *pairing_tables(record)]
        return as_html(headline(self.updated), tables, self._notes)

    @property
    def local_laws(self) -> list[LocalLaws]:
        """Laws near every sweep."""
        return sweep_laws(self.updated.temperature, self.updated.material, self.laws)

    @property
    def _notes(self) -> tuple[str, ...]:
        return (*self.frf.notes, *notes(self.updated, self.laws, self.pairing))


def compute(
    request: UpdateRequest, report: Progress, *, run: Path | None = None, plain: Updating | None = None
) -> Updating:
    """Fit the material of a campaign's twin to its FRFs, and laws through the estimates.

    Parameters
    ----------
    report : callable
        Called with a stage's name and the share of it done.
    run : Path, optional
        Run folder whose modes.h5 gives the measured modes to pair, if it is of these recordings.
    plain : Updating, optional
        What `updated_twin` gives for the same campaign, mains and run, where that is known.

    Raises
    ------
    ResultFileError
        For a campaign that cannot be fitted, with the reason.
    """
    found = plain or updated_twin(request.campaign, request.mains, report, run)
    if request.start is not None:
        found = _updated_under_effects(request.campaign, found, request.start, request.effects, report)
    reasoned = with_reason(request.campaign.experiment, found.frf, found.measured, found.pairing, report)
    return replace(found, pairing=reasoned)


def save(run: Path, request: UpdateRequest, found: Updating) -> None:
    """Write frf.h5 and laws.h5: FRFs, estimates, laws and the twin's FRFs; OSError where a file is refused."""
    made_from = request.origin()
    save_frf(run / "frf.h5", request.campaign.experiment, found.frf, made_from)
    save_laws(run / "laws.h5", found.updated, found.laws, found.twin, made_from, pairing_record(found.pairing))


def updated_twin(campaign: AnyCampaign, mains: float, report: Progress, run: Path | None = None) -> Updating:
    """Fit the twin without effects, as `compute` does, but for the likely reason where it is no fit.

    Parameters
    ----------
    mains : float
        Frequency of the mains, Hz.
    report : callable
        Called with a stage's name and the share of it done.
    run : Path, optional
        As in `compute`.

    Raises
    ------
    ResultFileError
        Where the campaign cannot be fitted.
    """
    frf, twin, updated = _fitted(campaign, mains, report)
    protocol = campaign.experiment.protocol
    laws = laws_of_sweeps(
        updated.temperature, updated.material, updated.own_sigma, updated.settled, protocol, updated.common
    )
    local = sweep_laws(updated.temperature, updated.material, laws)
    found = updated.departures

    def answer(law: LocalLaws, point: SweepPoint) -> NDArray[np.complex128]:
        return np.asarray(updated.gains[point.source] * twin.frf(law, frf.frequency, found, point))

    with ForkedExecutor() as executor:
        answers = list(executor.map(answer, local, sweep_points(frf, protocol)))
    density = campaign.experiment.plate.density
    seen = TwinFrf(frf.frequency, np.array(answers), twin.error, density)
    older = () if run is None else said_of_older_modes(run / "modes.h5", campaign)
    of_temperatures = (*recorded_notes(campaign), *label_notes(campaign, frf, updated))
    band = float(frf.frequency[0]), float(frf.frequency[-1])
    gains = gain_notes(updated, campaign.experiment.inputs, band)
    frf = replace(frf, notes=(*frf.notes, *gains, *of_temperatures, *drift_notes(protocol, updated, laws), *older))
    measured = measured_sweeps(campaign, frf, updated, report, run=run, mains=mains)
    pairs = paired_sweeps(campaign.experiment, frf, updated, measured, twin, local, seen.h, found)
    return Updating(frf, updated, laws, seen, measured, Pairing.of(pairs))


def _fitted(campaign: AnyCampaign, mains: float, report: Progress) -> tuple[Frf, Twin[EffectPlate], Updated]:
    """Measured FRFs with inverted channels corrected, the twin, and its material in every sweep."""
    protocol = campaign.experiment.protocol
    with judging(campaign):
        frf = campaign_frf(campaign, mains=mains)
        frf.require_noise()  # checked before a twin is built
        require_bending(campaign.experiment.plate, frf.frequency)
        if not twin_is_built(campaign.experiment):
            from app.stages.comparison.declaration_check import check_declaration  # slow import: mesher

            frf = replace(frf, notes=(*frf.notes, *check_declaration(campaign.experiment, frf, report)))
        tolerant = tolerant_twin(campaign.experiment, report)
        sheet = _sheet(campaign.experiment.plate.material)
        known = sheet_start(frf, tolerant, report)
        if known:  # about the moduli found, where it is more exact than about those declared
            tolerant = tolerant_twin(campaign.experiment, report, known)
        twin: TwinModel = HeldEffects(tolerant, known) if known else campaign_twin(campaign.experiment, report)
        frf, begin = polarity_corrected(frf, twin, report)

        def nearer(declared: Effects) -> Twin[EffectPlate] | None:
            nonlocal tolerant
            if not placed(campaign.experiment, declared)[1]:
                return None
            tolerant = tolerant_twin(campaign.experiment, report, {**known, **declared})
            return tolerant

        fitted = partial(
            update,
            tolerant=tolerant,
            sheet=sheet,
            declared=known,
            protocol=protocol,
            nearer=nearer,
            progress=report,
        )
        updated = fitted(frf, twin, begin=begin)
        outliers = outlier_sweeps(frf, updated)
        if outliers:
            frf = frf.without(
                outliers,
                "no material explains it although it explains the neighbours: overload, a knock, or a wrong file",
            )
            updated = fitted(frf, twin)
        lines = frf.frequency
        notes = unresolved(
            (float(lines[0]), float(lines[-1])),
            float(lines[1] - lines[0]),
            float(np.median(updated.material.loss_factor)),
        )
        return replace(frf, notes=(*frf.notes, *notes)), tolerant, updated


def _sheet(material: PlateMaterial | None) -> Orthotropy | None:
    """Return what is declared of an orthotropic sheet; None of an isotropic one."""
    return None if material is None else material.departure


def _updated_under_effects(
    campaign: AnyCampaign, without: Updating, start: Start, folder: Path | None, report: Progress
) -> Updating:
    """Fit with the effects of a twin file held at their values; sweeps at one temperature share E, nu and eta."""
    protocol = campaign.experiment.protocol
    frf, plain = without.frf, without.updated
    twin, given = campaign_model(campaign.experiment, plain, report, start, folder)
    model = HeldEffects(twin, start.twin.effects)
    report("laws under effects", 0.0)
    with ForkedExecutor() as executor, judging(campaign):
        steady = to_first_order(frf, model, without.local_laws, plain.gains, protocol, executor)
        fitted = fit_twin(steady, plain, model, protocol, executor, given)
        found = corrected_twin(frf, plain, model, protocol, fitted, executor)
    report("laws under effects", 1.0)
    density = campaign.experiment.plate.density
    seen = TwinFrf(frf.frequency, found.answers, twin.error, density)
    measured, local = without.measured, sweep_laws(found.updated.temperature, found.updated.material, found.laws)
    effects = {**start.twin.effects, **found.updated.departures}
    pairs = paired_sweeps(campaign.experiment, frf, found.updated, measured, twin, local, seen.h, effects)
    return Updating(frf, found.updated, found.laws, seen, measured, Pairing.of(pairs))
