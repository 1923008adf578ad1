"""Identify stage: modes of a campaign, computed and saved, and modes of single FRFs of universal files."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from analysis.estimation.transfer import MeasuredTransfer
from analysis.experiment import Experiment
from analysis.gap.data.preparation import sweep_points
from analysis.identification.judgement.confirmation import confirmed, confirmed_by_neighbours
from analysis.identification.over_temperature.stated_temperature import at_stated_temperature
from analysis.identification.over_temperature.tracked_modes import TrackedModes
from analysis.identification.over_temperature.tracking import sweep_measured, track
from analysis.identification.pole_residue import choices_for
from analysis.labelled import Labelled, LabelledArrays
from analysis.progress import Progress
from analysis.recordings.frf import Frf, campaign_frf, sweeps_of_actuator
from analysis.recordings.frf_campaign import AnyCampaign
from app.files.bad_file import ResultFileError
from app.files.campaigns.export import export_frfs, nearest_sweep, sweep_name
from app.files.campaigns.inputs import campaign_settings
from app.files.provenance import provenance, sha256
from app.files.results.modes_file import save_frf, save_modes, write_table
from app.files.results.run_folder import run_file
from app.modal_test.frf_set import said_of_coherence, said_of_reference
from app.stages.comparison.temperature_notes import resonance_notes, untimed
from app.stages.identify_options import Wanted
from app.summaries.modes import headline, modes_record, tables
from app.summaries.table import as_html, as_text


@dataclass(frozen=True)
class IdentifiedCampaign(Labelled):
    """Result of the identify stage.

    Attributes
    ----------
    frf : Frf
        All lines, inside the band and outside; of several actuators, the sweeps of one.
    tracked : TrackedModes
        Of the lines inside the band.
    inputs : mapping
        SHA-256 of every input file, by its name.
    every : Frf
        The FRFs of all actuators.
    """

    frf: Frf
    tracked: TrackedModes
    inputs: Mapping[str, str]
    every: Frf

    def labelled(self) -> LabelledArrays:
        """Modes over sweep, see `TrackedModes.labelled`."""
        return self.tracked.labelled()

    def __repr__(self) -> str:
        """Sweeps, modes and misfit in one line, and the notes."""
        return as_text(f"IdentifiedCampaign: {headline(self.tracked)}", (*self.frf.notes, *self.tracked.notes))

    def _repr_html_(self) -> str:
        notes = (*self.frf.notes, *self.tracked.notes)
        return as_html(headline(self.tracked), tables(self.tracked), notes)


def compute(
    campaign: AnyCampaign, wanted: Wanted, report: Progress, twin: Path | None = None
) -> IdentifiedCampaign:
    """Identify every sweep of a campaign, and follow its modes over temperature.

    Parameters
    ----------
    report : callable
        Called with a stage's name and the share of it done.
    twin : Path, optional
        Run folder of ``flexura update`` whose twin predicts the modes.

    Raises
    ------
    ResultFileError
        For a sensor without signal, a band without lines, a temperature to export that was not measured, or laws
        of another campaign.
    """
    inputs = dict(campaign.hashes)
    try:
        every = campaign_frf(campaign, mains=wanted.settings.mains or 50.0)
        frf, expected = sweeps_of_actuator(every, wanted.actuator), None
        inside = wanted.cut(frf)
        if wanted.temperature is not None:
            nearest_sweep(frf, wanted.temperature)
        if twin is not None:
            from app.twins.expected_modes import expected_modes

            laws = run_file(twin, "laws.h5", "update")
            expected, inputs["laws.h5"] = expected_modes(campaign, laws, report), sha256(laws)
            expected = replace(expected, poles=expected.poles[every.driven_by == frf.driven_by[0]])
        settings = replace(wanted.settings, terms=choices_for(_quantities(campaign.experiment)))
        tracked = track(inside, settings, report, wanted.one_by_one(), expected)
        tracked = _confirmed(inside, tracked).read_as(wanted.damping)
        protocol = campaign.experiment.protocol
        tracked = at_stated_temperature(tracked, sweep_points(inside, protocol), inside.shift)
        tracked = replace(tracked, notes=(*tracked.notes, *untimed(protocol), *resonance_notes(campaign, every)))
    except ValueError as error:
        raise ResultFileError(f"{campaign.name}: {error}") from error
    return IdentifiedCampaign(frf, tracked, inputs, every)


def _quantities(experiment: Experiment) -> set[str]:
    """Quantities that the outputs follow: a patch follows the strain, and so the displacement."""
    return {"displacement" if one.patch is not None else one.quantity for one in experiment.outputs}


def _confirmed(frf: Frf, tracked: TrackedModes) -> TrackedModes:
    """Confirm modes by sweeps of neighbouring temperatures, and sweeps without a neighbour by refits."""
    measured = [sweep_measured(frf, t) for t in range(len(tracked.modes))]
    judged = confirmed_by_neighbours(tracked, measured)
    modes = (m if m.confirmation else confirmed(own, m) for own, m in zip(measured, judged.modes, strict=True))
    return replace(judged, modes=tuple(modes))


def save(
    run: Path, campaign: AnyCampaign, found: IdentifiedCampaign, wanted: Wanted, export: Path | None = None
) -> None:
    """Write frf.h5, modes.h5 and modes.csv, and the FRFs for other programs if requested.

    Parameters
    ----------
    run : Path
        Run folder.
    wanted : Wanted
        Stored in the provenance.
    export : Path, optional
        File for the FRFs, its format by its ending: of the sweep nearest to the temperature wanted, or of all.

    Raises
    ------
    OSError
        Where a file cannot be written.
    """
    made_from = provenance(found.inputs, campaign_settings(campaign) | wanted.record())
    save_frf(run / "frf.h5", campaign.experiment, found.every, made_from)  # as written by update and gap
    if export is not None:
        sweep = None if wanted.temperature is None else nearest_sweep(found.frf, wanted.temperature)
        export_frfs(export, campaign.experiment, found.frf, sweep)
    save_modes(run / "modes.h5", found.tracked, made_from)
    write_table(run / "modes.csv", found.tracked)


def said_of_export(export: Path, found: IdentifiedCampaign, temperature: float | None) -> str:
    """Say which sweeps an export of the campaign holds.

    Parameters
    ----------
    export : Path
        The file.
    temperature : float or None
        As wanted.
    """
    if temperature is not None:
        return f"{export}: FRFs of the sweep {sweep_name(found.frf, nearest_sweep(found.frf, temperature))}"
    count = len(found.frf.temperature)
    if count == 1:
        return f"{export}: FRFs of one sweep"
    if export.suffix.lower() == ".csv":
        return f"{export.with_name(export.stem)}_*.csv: FRFs of {count} sweeps, a file each"
    return (
        f"{export}: FRFs of {count} sweeps. For --shared-poles and focus --transfers write one: --temperature 20"
    )


def uff_records(frfs: Sequence[MeasuredTransfer], wanted: Wanted, report: Progress) -> list[dict[str, Any]]:
    """Identify FRFs one by one; an FRF without modes gets a note.

    Parameters
    ----------
    report : callable
        Called with a stage's name and the share of it done.

    Returns
    -------
    list of dict
        One per FRF, as ``--json`` prints it.
    """
    records = []
    for done, frf in enumerate(frfs):
        report("identify", done / len(frfs))
        said = [*said_of_reference([frf]), *said_of_coherence([frf])]
        try:
            found = modes_record(wanted.identify([frf]))
        except ValueError as error:
            found = {"residual_terms": None, "misfit": None, "modes": [], "rejected": []}
            said = [*said, str(error)]
        named = {key: getattr(frf, key) for key in ("name", "response", "reference", "quantity")}
        records.append(named | found | ({"note": "; ".join(said)} if said else {}))
    report("identify", 1.0)
    return records
