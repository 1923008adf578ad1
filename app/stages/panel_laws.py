"""Material laws of a panel's plate, and their common temperature range with the panel."""

from pathlib import Path

import numpy as np

from analysis.arrays import Real
from analysis.focusing.panel import Panel
from analysis.focusing.temperatures import covered
from analysis.material import Material, MaterialLaws
from app.files.bad_file import ResultFileError
from app.files.laws_file import load_laws
from app.files.run_folder import run_file
from app.files.twin_file import TwinFile, read_twin


def laws_of(run: Path, verb: str) -> tuple[Path, MaterialLaws]:
    """Return the laws of a run folder or of a laws file, and the path of that file."""
    path = run if run.is_file() else run_file(run, "laws.h5", verb)
    return path.resolve(), load_laws(path)


def laws_for(run: Path | None, twin: Path | None, verb: str) -> tuple[Path, MaterialLaws, Path]:
    """Return the laws of a run, or of a twin file if one is named.

    Parameters
    ----------
    run : Path or None
        Run folder; None for the current folder.
    twin : Path or None
        Twin file.
    verb : str
        Name of the calling command, for messages.

    Returns
    -------
    path : Path
        File of the laws.
    laws : MaterialLaws
    folder : Path
        Folder for results: that of the laws; with a twin file `run`, if that is a folder.
    """
    if twin is None:
        path, laws = laws_of(run or Path(), verb)
        return path, laws, path.parent
    path = twin.resolve()
    return path, laws_of_twin(read_twin(twin), path), run if run is not None and run.is_dir() else path.parent


def laws_of_twin(twin: TwinFile, origin: Path) -> MaterialLaws:
    """Smooth laws through the nodes of a twin file; ResultFileError for fewer than three."""
    from analysis.updating.laws import fit_laws

    nodes = twin.laws
    material = Material(*(np.array(x) for x in (nodes.youngs_modulus, nodes.poisson_ratio, nodes.loss_factor)))
    spread = (nodes.sigma_youngs_modulus, nodes.sigma_poisson_ratio, nodes.sigma_loss_factor)
    sigma = Material(*(np.array(x) for x in spread))
    try:
        return fit_laws(np.array(nodes.temperature), material, sigma, temperature_range=nodes.temperature_range)
    except ValueError as error:
        raise ResultFileError(f"{origin}: laws: {error}") from error


def effects_left_out(twin: Path) -> list[str]:
    """Return a note on the effects of a twin file that do not apply to a panel; empty if there are none."""
    effects = list(read_twin(twin).effects)
    if not effects:
        return []
    stay = f"{', '.join(effects)} {'stays' if len(effects) == 1 else 'stay'}"
    return [f"{twin}: the panel's plate obeys the corrected laws; {stay} with the plate that was measured"]


def range_of(panel: Panel, laws: MaterialLaws, origin: Path) -> tuple[float, float]:
    """Return the common temperature range of panel and laws.

    Parameters
    ----------
    panel : Panel
    laws : MaterialLaws
    origin : Path
        File of the laws, for messages.

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
        raise ResultFileError(f"{origin}: {error}; update a campaign that covers them") from error


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
    laws : MaterialLaws
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
