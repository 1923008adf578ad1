"""Radiation stage: the sound of a panel with the filters of a run, computed and saved."""

from collections.abc import Mapping
from pathlib import Path

from analysis.campaign_extent import CampaignExtent
from analysis.focusing.fir import FirBank
from analysis.focusing.measured import MeasuredPanel
from analysis.focusing.panel import Panel
from analysis.focusing.radiated import Radiation, radiate, radiate_measured
from analysis.material import MaterialLaws
from analysis.progress import Progress
from app.files.bad_file import ResultFileError
from app.files.campaign_inputs import extent_settings
from app.files.provenance import provenance
from app.files.radiation_file import save_radiation
from app.twins.panel_twin import panel_twin

RADIATION = "radiation.h5"


def compute(panel: Panel, laws: MaterialLaws, bank: FirBank, reference: float, report: Progress) -> Radiation:
    """Compute the sound of a panel whose plate obeys laws.

    Parameters
    ----------
    laws : MaterialLaws
        As measured; thermal expansion of the panel's plate is added here.
    reference : float
        Temperature of the filters that are kept, degrees Celsius.
    report : callable
        Called with a stage's name and the share of it done.

    Raises
    ------
    ResultFileError
        For a grid too coarse for the wavelength, and laws that leave the panel's twin.
    """
    laws = panel.plate.grown(laws)
    model = panel_twin(panel, laws, report)
    try:
        return radiate(model, panel, laws, bank, reference, report)
    except ValueError as error:
        raise ResultFileError(f"the panel's grid: {error}") from error


def compute_measured(measured: MeasuredPanel, bank: FirBank, reference: float, report: Progress) -> Radiation:
    """Compute the sound of a panel from its measured transfers.

    Parameters
    ----------
    reference : float
        Temperature of the filters that are kept, degrees Celsius.
    report : callable
        Called with a stage's name and the share of it done.

    Raises
    ------
    ResultFileError
        For points too coarse for the wavelength, and filters of other temperatures.
    """
    try:
        return radiate_measured(measured, bank, reference, report)
    except ValueError as error:
        raise ResultFileError(f"the measured transfers: {error}") from error


def save(
    run: Path,
    panel: Panel,
    found: Radiation,
    inputs: Mapping[str, str],
    extent: CampaignExtent | None = None,
) -> Path:
    """Write radiation.h5.

    Parameters
    ----------
    run : Path
        Run folder.
    inputs : mapping
        SHA-256 of every input file, by its name.
    extent : CampaignExtent, optional
        Of the campaign that the laws are from, where that was not complete.

    Returns
    -------
    Path
        File written.

    Raises
    ------
    OSError
        Where it cannot be written.
    """
    target = run / RADIATION
    settings = {"panel": panel.model_dump(mode="json"), **extent_settings(extent)}
    save_radiation(target, panel, found, provenance(inputs, settings))
    return target
