"""Panel, method and processor for ``focus`` and ``compensate``, and a panel's measured transfers."""

import json
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from analysis.focusing.measured import MeasuredPanel
from analysis.focusing.methods import Method
from analysis.focusing.panel import Panel
from analysis.focusing.sound_aim import SoundAim
from analysis.recordings.campaign import CampaignExtent
from analysis.weather.declared_weather import Weather
from app.files.bad_file import ResultFileError, UnsuitedOptionError, quoted
from app.files.declarations.panel import SECTION_2, panel_of_text, read_panel
from app.files.provenance import sha256
from app.files.results.laws_file import remember_laws
from app.files.results.panel_files import load_method, load_panel, made_from_transfers
from app.stages.panel.laws import PanelLaws


@dataclass(frozen=True, kw_only=True)
class PanelTask:
    """What a request for filters of a panel came to, before anything is computed.

    Attributes
    ----------
    inputs : tuple of Path
        Files that the filters are made from.
    beside : Path
        Folder for results where none is named.
    notes : list of str
    extent : CampaignExtent or None
        Of an incomplete campaign whose laws are used.
    laws : PanelLaws or None
        None for measured transfers.
    """

    inputs: tuple[Path, ...]
    beside: Path
    notes: list[str]
    extent: CampaignExtent | None = None
    laws: PanelLaws | None = None

    def remember(self, folder: Path) -> None:
        """Write into a folder of results where their laws are, if they are elsewhere."""
        if self.laws is not None:
            remember_laws(folder, self.laws.path, kind=self.laws.kind)

    def hashes(self) -> dict[str, str]:
        """SHA-256 of the files that the filters are made from, by name."""
        return {path.name: sha256(path) for path in self.inputs}


def require_same_filters(folder: Path, beside: Path, panel: Panel, method: Method, origin: Path) -> None:
    """Refuse results beside filters of another panel, or of other settings of it, in a folder of their own.

    Parameters
    ----------
    folder : Path
        For the results.
    beside : Path
        Run folder that they follow from; filters in it are replaced by its own.
    panel : Panel
        That the results are of.
    origin : Path
        File that the panel comes from.

    Raises
    ------
    UnsuitedOptionError
        With the command that follows the filters that are there.
    """
    made = folder / "filters.h5"
    if folder.resolve() == beside.resolve() or not made.is_file():
        return
    there, other = load_panel(made), load_method(made)
    if (there, other) != (panel, method):
        which = f"of {there.title!r}" if there.title != panel.title else "of other settings of this panel"
        raise UnsuitedOptionError(
            f"--out {folder}: holds filters {which}; those to be followed are of {panel.title!r}, from {origin}. "
            f"To follow the filters there: flexura compensate {quoted(folder)}; or name another folder with --out"
        )


def panel_of(path: Path | None, changes: Mapping[str, Any]) -> tuple[Panel, Path]:
    """Return the panel of a file, or the shipped one, with the filter settings in `changes` replaced."""
    path = path or SECTION_2
    panel = changed(read_panel(path), changes)
    return panel, path


def changed(panel: Panel, changes: Mapping[str, Any]) -> Panel:
    """Panel with some filter settings replaced and validated; None keeps a setting."""
    given = {name: value for name, value in changes.items() if value is not None}
    if not given:
        return panel
    declared = panel.model_dump(mode="json")
    declared["filters"] |= given
    if "taps" in given and "delay" not in given:
        declared["filters"]["delay"] = None  # the default delay depends on the length
    return panel_of_text(json.dumps(declared), "command line")


def weather_for(path: Path, panel: Panel, method: Method) -> Weather:
    """Read the weather in which filters of a panel are judged.

    Raises
    ------
    UnsuitedOptionError
        For filters of another method than STIF.
    ResultFileError
        For a thermometer off the plate.
    CampaignFileError
        For what is wrong in the file itself.
    """
    from app.files.declarations.panel import read_weather
    from app.twins.warm_twin import check_thermometers

    if method != "stif":
        raise UnsuitedOptionError(f"--weather judges filters of the method stif; the method here is {method}")
    weather = read_weather(path)
    check_thermometers(panel.plate, weather, str(path))
    return weather


def panel_for(path: Path | None, run: Path, changes: Mapping[str, Any]) -> tuple[Panel, Path]:
    """Return the panel of a file, or else that of the run's filters, or else the shipped one.

    Parameters
    ----------
    path : Path or None
        File of the panel.
    changes : mapping
        Filter settings to be replaced, by key; None leaves one as it is.

    Returns
    -------
    panel : Panel
    path : Path
        File it comes from.

    Raises
    ------
    ResultFileError
        Where these filters were designed from measured transfers, so that there is no twin.
    """
    made = run / "filters.h5"
    if path is None and made.is_file() and made_from_transfers(made):
        raise ResultFileError(
            f"{made}: designed from measured transfers, which no material laws carry to other temperatures; "
            "name a panel that can be computed with --panel (flexura compensate follows them with --transfers)"
        )
    return scanned_panel(path, run, changes)


def scanned_panel(path: Path | None, run: Path, changes: Mapping[str, Any]) -> tuple[Panel, Path]:
    """Return the panel of a file, or else that of a run's filters, from laws or measured transfers.

    Parameters
    ----------
    path : Path or None
        File of the panel.
    changes : mapping
        Filter settings to be replaced, by key; None leaves one as it is.

    Returns
    -------
    panel : Panel
    path : Path
        File it comes from.

    Raises
    ------
    ResultFileError
        Where it cannot be read.
    """
    made = run / "filters.h5"
    if path is None and made.is_file():
        return changed(load_panel(made), changes), made
    return panel_of(path, changes)


def measured_panel(panel: Panel, path: Path, temperatures: tuple[float, ...]) -> MeasuredPanel:
    """Join a panel to its measured transfers.

    Parameters
    ----------
    path : Path
        See `read_transfers`.
    temperatures : tuple of float
        The one at which a universal file was measured, degrees Celsius; empty for the panel's reference.

    Raises
    ------
    ResultFileError
        For more than one temperature, and where panel and transfers do not fit each other.
    """
    from app.files.results.transfers_file import read_transfers  # slow import: readers of universal files

    if len(temperatures) > 1 or not np.isfinite(temperatures).all():
        raise ResultFileError(f"--temperature {temperatures}: one, at which {path} was measured, in °C")
    transfers = read_transfers(path, panel.filters.edges, *temperatures or (panel.filters.reference_temperature,))
    if temperatures and temperatures != tuple(transfers.temperature):
        held = ", ".join(f"{t:g}" for t in transfers.temperature)
        raise ResultFileError(
            f"--temperature {temperatures[0]:g} °C: {path} was measured at {held} °C; leave it out"
        )
    if panel.filters.thermometer_error > 0.0:
        raise ResultFileError(
            f"{path}: thermometer_error {panel.filters.thermometer_error:g} °C needs a model of the panel at "
            "other temperatures; leave it at 0"
        )
    count = transfers.transfer.shape[1]
    if count != len(panel.centers):
        raise ResultFileError(f"{path}: transfers of {count} actuators; the panel declares {len(panel.centers)}")
    off = ~panel.plate.contains(transfers.points)
    if off.any():
        x, y = transfers.points[int(np.argmax(off))]
        raise ResultFileError(f"{path}: point {int(np.argmax(off)) + 1} at ({x:g}, {y:g}) m is outside the plate")
    measured = MeasuredPanel(panel, transfers)
    try:
        measured.grid  # noqa: B018 - computed here to report its errors
    except ValueError as error:
        raise ResultFileError(f"{path}: {error}; measure points on the target") from error
    if panel.filters.aim != "field" or panel.sound.listener:
        try:
            SoundAim.judging(panel, measured.grid)
        except ValueError as error:
            raise ResultFileError(f"{path}: {error}") from error
    return measured


def require_aim(panel: Panel, method: Method) -> None:
    """Raise UnsuitedOptionError for an aim at sound with a method that has no choice of its field."""
    if panel.filters.aim != "field" and method != "stif":
        raise UnsuitedOptionError(
            f"--method {method}: the aim {panel.filters.aim!r} is for stif; take --method stif or --aim field"
        )


def method_for(named: Method | None, path: Path | None, run: Path) -> Method:
    """Return the method named, or else that of the run's filters if their panel is used, or STIF.

    Parameters
    ----------
    named : str or None
    path : Path or None
        File of the panel; None if the run's panel is used.

    Returns
    -------
    str
    """
    made = run / "filters.h5"
    return named or (load_method(made) if path is None and made.is_file() else "stif")


def workers() -> int:
    """Return the number of threads that compute temperatures: one per core, limited by the memory for fields."""
    return min(os.cpu_count() or 1, 16)


def checked_device(device: str) -> None:
    """Raise ResultFileError unless networks can be trained on `device`: ``cpu`` or a device of torch."""
    if device == "cpu":
        return
    if not re.fullmatch(r"(cuda|mps|xpu)(:\d+)?", device):
        raise ResultFileError(f"--device {device}: no device for networks; allowed: cpu, cuda, cuda:1, mps, xpu")
    try:
        import torch
    except ImportError as error:
        raise ResultFileError(
            f"--device {device}: torch is not installed, as in a lean environment; install it with: "
            "python3 start.py (without --lean), or pip install torch; or take cpu"
        ) from error

    try:
        torch.zeros(1, dtype=torch.float64, device=device)
    except (RuntimeError, AssertionError, ValueError) as error:
        reason = str(error).splitlines()[0]
        raise ResultFileError(f"--device {device}: torch cannot use it ({reason}); take cpu") from error
