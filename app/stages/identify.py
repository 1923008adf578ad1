"""Identify stage: modes of a campaign, computed and saved, and modes of single FRFs of universal files."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np

from analysis.campaign import Campaign
from analysis.chosen_actuator import sweeps_of_actuator
from analysis.estimation.transfer import MeasuredTransfer
from analysis.experiment import Experiment
from analysis.frf import Frf, campaign_frf
from analysis.identification.automatic import identify
from analysis.identification.confirmation import confirmed, confirmed_by_neighbours
from analysis.identification.measured import Measured
from analysis.identification.modes import Modes
from analysis.identification.peak_picking import identify_by_peaks
from analysis.identification.reading import Damping
from analysis.identification.residual_terms import choices_for
from analysis.identification.settings import Settings
from analysis.identification.tracked_modes import TrackedModes
from analysis.identification.tracking import sweep_measured, track
from analysis.progress import Progress
from app.files.bad_file import ResultFileError
from app.files.frf_file import save_frf
from app.files.modes_file import save_modes, write_table
from app.files.provenance import provenance, sha256
from app.files.run_folder import run_file
from app.files.uff58 import write_frfs
from app.files.uff_campaign import campaign_frfs
from app.modal_test.frf_set import said_of_coherence
from app.terminal.modes import headline, modes_record, tables
from app.terminal.notebook import as_html, as_text

Method = Literal["auto", "peak-picking"]


@dataclass(frozen=True)
class Wanted:
    """Options of the identification.

    Attributes
    ----------
    settings : Settings
        Of the search.
    damping : str
        ``hysteretic`` or ``viscous`` reading of poles.
    method : str
        ``auto`` or ``peak-picking``.
    band : (float, float) or None
        Hz; None for all lines.
    actuator : str or None
        Which actuator's sweeps are used, if several drove the plate in turn; None for the first.
    """

    settings: Settings
    damping: Damping
    method: Method
    band: tuple[float, float] | None
    actuator: str | None = None

    def __post_init__(self) -> None:
        for name, choices in (("damping", get_args(Damping)), ("method", get_args(Method))):
            if getattr(self, name) not in choices:
                raise ValueError(f"{name} {getattr(self, name)!r}: {' or '.join(choices)}")
        if self.band is not None and not 0.0 <= self.band[0] < self.band[1]:
            raise ValueError(f"band {self.band[0]:g} to {self.band[1]:g} Hz: two frequencies, ascending, wanted")

    def record(self) -> dict[str, Any]:
        """Return the options in the form stored in a result file's provenance."""
        return {
            "method": self.method,
            "damping": self.damping,
            "band_hz": None if self.band is None else list(self.band),
            "mains_hz": self.settings.mains,
            "start_count": self.settings.start_count,
            "most_count": self.settings.most_count,
            **({} if self.actuator is None else {"actuator": self.actuator}),
        }

    def at_mains(self, mains: float) -> "Wanted":
        """Return the options with another mains frequency, Hz."""
        return replace(self, settings=replace(self.settings, mains=mains))

    def cut(self, frf: Frf) -> Frf:
        """Return a campaign's FRFs on the lines inside the band."""
        if self.band is None:
            return frf
        inside = (frf.frequency >= self.band[0]) & (frf.frequency <= self.band[1])
        return replace(
            frf,
            frequency=frf.frequency[inside],
            h=frf.h[:, :, inside],
            variance=frf.variance[:, :, inside],
            coherence=frf.coherence[:, :, inside],
            excluded=frf.excluded[inside],
        )

    def one_by_one(self) -> Callable[[Measured, Settings], Modes] | None:
        """Return the method that identifies each sweep alone, or None where sweeps are fitted jointly."""
        return identify_by_peaks if self.method == "peak-picking" else None

    def identify(self, frfs: Sequence[MeasuredTransfer]) -> Modes:
        """Identify FRFs with common poles and lines; ValueError if there is nothing to identify."""
        terms = choices_for({frf.quantity for frf in frfs})
        frequency = frfs[0].frequency
        low, high = self.band or (0.0, np.inf)
        inside = (frequency >= low) & (frequency <= high)
        known = [frf.variance[inside] for frf in frfs if frf.variance is not None]
        variance = np.array(known) if len(known) == len(frfs) else None
        measured = Measured(frequency[inside], np.array([frf.h[inside] for frf in frfs]), variance)
        settings = replace(self.settings, terms=terms)
        return confirmed(measured, (self.one_by_one() or identify)(measured, settings)).read_as(self.damping)


@dataclass(frozen=True)
class IdentifiedCampaign:
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

    def __repr__(self) -> str:
        """Sweeps, modes and misfit in one line, and the notes."""
        return as_text(f"IdentifiedCampaign: {headline(self.tracked)}", (*self.frf.notes, *self.tracked.notes))

    def _repr_html_(self) -> str:
        notes = (*self.frf.notes, *self.tracked.notes)
        return as_html(headline(self.tracked), tables(self.tracked), notes)


def compute(campaign: Campaign, wanted: Wanted, report: Progress, twin: Path | None = None) -> IdentifiedCampaign:
    """Identify every sweep of a campaign, and follow its modes over temperature.

    Parameters
    ----------
    campaign : Campaign
    wanted : Wanted
    report : callable
        Called with a stage's name and the share of it done.
    twin : Path, optional
        Run folder of ``flexura update`` whose twin predicts the modes.

    Returns
    -------
    IdentifiedCampaign

    Raises
    ------
    ResultFileError
        For a sensor without signal, a band without lines, or laws of another campaign.
    """
    inputs = dict(campaign.hashes)
    try:
        every = campaign_frf(campaign, mains=wanted.settings.mains or 50.0)
        frf, expected = sweeps_of_actuator(every, wanted.actuator), None
        if twin is not None:
            from app.twins.expected_modes import expected_modes

            laws = run_file(twin, "laws.h5", "update")
            expected, inputs["laws.h5"] = expected_modes(campaign, laws, report), sha256(laws)
            expected = replace(expected, poles=expected.poles[every.driven_by == frf.driven_by[0]])
        settings = replace(wanted.settings, terms=choices_for(_quantities(campaign.experiment)))
        tracked = track(wanted.cut(frf), settings, report, wanted.one_by_one(), expected)
        tracked = _confirmed(wanted.cut(frf), tracked).read_as(wanted.damping)
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
    run: Path, campaign: Campaign, found: IdentifiedCampaign, wanted: Wanted, export: Path | None = None
) -> None:
    """Write frf.h5, modes.h5 and modes.csv, and the FRFs as a universal file if requested.

    Parameters
    ----------
    run : Path
        Run folder.
    campaign : Campaign
    found : IdentifiedCampaign
    wanted : Wanted
        Stored in the provenance.
    export : Path, optional
        Universal file for the FRFs.

    Raises
    ------
    OSError
        Where a file cannot be written.
    """
    made_from = provenance(found.inputs, {"campaign": campaign.name} | wanted.record())
    save_frf(run / "frf.h5", campaign.experiment, found.every, made_from)  # as written by update and gap
    if export is not None:
        write_frfs(export, campaign_frfs(campaign.experiment, found.frf))
    save_modes(run / "modes.h5", found.tracked, made_from)
    write_table(run / "modes.csv", found.tracked)


def uff_records(frfs: Sequence[MeasuredTransfer], wanted: Wanted, report: Progress) -> list[dict[str, Any]]:
    """Identify FRFs one by one; an FRF without modes gets a note.

    Parameters
    ----------
    frfs : sequence of MeasuredTransfer
    wanted : Wanted
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
        said = said_of_coherence([frf])
        try:
            found = modes_record(wanted.identify([frf]))
        except ValueError as error:
            found = {"residual_terms": None, "misfit": None, "modes": [], "rejected": []}
            said = [*said, str(error)]
        named = {key: getattr(frf, key) for key in ("name", "response", "reference", "quantity")}
        records.append(named | found | ({"note": "; ".join(said)} if said else {}))
    report("identify", 1.0)
    return records
