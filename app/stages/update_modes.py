"""Update stage of a plate whose modes are known, without FRFs: computed and saved."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from analysis.arrays import Complex
from analysis.estimates import MODULI
from analysis.material import LocalLaws, MaterialLaws
from analysis.progress import Progress
from analysis.recordings.frf_campaign import ModesAtTemperature
from analysis.recordings.sweep_point import SweepPoint
from analysis.twin_model import Effects
from analysis.updating.drift import sweep_laws
from analysis.updating.laws import laws_of_sweeps
from analysis.updating.modes_fit import FittedModes, fit_modes
from app.files.bad_file import ResultFileError
from app.files.provenance import provenance
from app.files.results.laws_file import TwinFrf, save_laws
from app.plate_frfs.plate_of_modes import PlateOfModes
from app.summaries.table import as_html, as_text
from app.summaries.update import headline, tables_of
from app.twins.campaign_twin import tolerant_twin
from app.twins.computed_modes import computed_poles

STORED_LINES = 400
"""Of the twin's FRFs that are stored beside the laws: enough to draw them, and little to compute."""


@dataclass(frozen=True)
class UpdatingByModes:
    """Result of the stage.

    Attributes
    ----------
    fitted : FittedModes
    measured : tuple of ModesAtTemperature
    laws : MaterialLaws or None
        None for fewer than three temperatures.
    twin : TwinFrf
        FRFs of the updated twin.
    """

    fitted: FittedModes
    measured: tuple[ModesAtTemperature, ...]
    laws: MaterialLaws | None
    twin: TwinFrf

    def __repr__(self) -> str:
        """Temperatures, ranges of E, nu and eta in one line, and the notes."""
        return as_text(f"UpdatingByModes: {headline(self.fitted.updated)}", self.fitted.held)

    def _repr_html_(self) -> str:
        return as_html(headline(self.fitted.updated), tables_of(self.fitted.updated), self.fitted.held)


def compute(plate: PlateOfModes, report: Progress) -> UpdatingByModes:
    """Fit the material of a plate's twin to its modes, and laws through the estimates.

    Parameters
    ----------
    report : callable
        Called with a stage's name and the share of it done.

    Raises
    ------
    ResultFileError
        For modes that cannot be fitted, with the reason.
    """
    experiment = plate.experiment
    twin = tolerant_twin(experiment, report)
    if MODULI in twin.tolerance_cards:
        raise ResultFileError(
            f"{plate.name}: an orthotropic sheet has more constants than a list of frequencies tells; give FRFs"
        )

    def poles(law: LocalLaws, values: Effects) -> Complex:
        found = computed_poles(twin, law, values)
        if found is None:
            raise ValueError("the twin has dashpots on its edges: its modes are not known, give FRFs")
        return found

    report("modes", 0.0)
    try:
        fitted = fit_modes(plate.modes, poles, twin.box, twin.tolerance_cards)
    except ValueError as error:
        raise ResultFileError(f"{plate.name}: {error}") from error
    updated = fitted.updated
    laws = laws_of_sweeps(
        updated.temperature,
        updated.material,
        updated.own_sigma,
        updated.settled,
        experiment.protocol,
        updated.common,
    )
    lines = np.linspace(*twin.band, STORED_LINES)
    answers = []
    for law, temperature in zip(
        sweep_laws(updated.temperature, updated.material, laws), updated.temperature, strict=True
    ):
        point = SweepPoint(float(temperature), 0.0, 1.0)
        answers.append(twin.frf(law, lines, updated.departures, point))
        report("modes", len(answers) / len(updated.temperature))
    seen = TwinFrf(lines, np.array(answers), twin.error, experiment.plate.density)
    return UpdatingByModes(fitted, plate.modes, laws, seen)


def save(run: Path, plate: PlateOfModes, found: UpdatingByModes) -> None:
    """Write laws.h5: estimates, laws and the twin's FRFs.

    Parameters
    ----------
    run : Path
        Run folder.

    Raises
    ------
    OSError
        Where the file cannot be written.
    """
    made_from = provenance(
        plate.hashes, {"campaign": plate.name, "modes": sum(len(m.frequency) for m in plate.modes)}
    )
    save_laws(run / "laws.h5", found.fitted.updated, found.laws, found.twin, made_from)
