"""What of a run is exported: filters that follow the temperature, and where they come from."""

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from analysis.compensation.network import InputMap
from analysis.compensation.outcome import NETWORK, Compensation
from analysis.focusing.fir import FirBank
from analysis.focusing.panel import Panel
from analysis.rendering.following import FollowingBank
from app.files.bad_file import ResultFileError
from app.files.compensation_file import load_compensation
from app.files.filter_files import load_focusing
from app.files.hdf5_file import result_file
from app.files.provenance import provenance, read_stamp, sha256
from app.files.run_folder import run_file

FORMAT = "flexura-filters/1"
"""Of all exports; a change that a reader would notice changes the number."""
SPLINE, RIGIDITY_SPLINE, LINEAR = "cubic-spline", "cubic-spline-rigidity", "linear"
METHODS = (NETWORK, SPLINE, RIGIDITY_SPLINE, LINEAR)
"""What can be exported: sums of fixed banks."""


@dataclass(frozen=True)
class Shipment:
    """Filters to be exported.

    Attributes
    ----------
    filters : FollowingBank
    method : str
        Of `METHODS`.
    names : tuple of str
        Of the actuators, in the order of the filters.
    panel : Panel
    made_from : dict
        Provenance: versions, settings, hashes of the run's files, and their own provenance.
    notes : tuple of str
        What has to be known of the choice.
    """

    filters: FollowingBank
    method: str
    names: tuple[str, ...]
    panel: Panel
    made_from: dict[str, Any]
    notes: tuple[str, ...] = ()

    @property
    def stamp(self) -> str:
        """Format and provenance as JSON, in ASCII."""
        return json.dumps({"format": FORMAT} | self.made_from, allow_nan=False)

    def chosen(self, settings: dict[str, Any]) -> "Shipment":
        """Return the same with further settings in its provenance."""
        kept = self.made_from | {"settings": self.made_from["settings"] | settings}
        return replace(self, made_from=kept)


def shipment(run: Path, method: str | None, verb: str) -> Shipment:
    """Find the filters of a run folder.

    Parameters
    ----------
    run : Path
        With compensation.h5, filters.h5 or both.
    method : str, optional
        One of `METHODS`; left out, what was found best by ``flexura compensate``, or else a spline through the
        filters of ``flexura focus``.
    verb : str
        For messages.

    Raises
    ------
    ResultFileError
        Where the run holds no filters, or not those the method needs.
    """
    needed = method in (NETWORK, RIGIDITY_SPLINE)
    if not needed and (method is not None or not (run / "compensation.h5").is_file()):
        return _joined(run, method or SPLINE, verb)
    path = run_file(run, "compensation.h5", verb)
    panel, found = load_compensation(path)
    wanted, note = method or found.best, ""
    if wanted not in METHODS:
        note = f"{wanted}, the best here, is no sum of fixed banks; {RIGIDITY_SPLINE} is taken in its place"
        wanted = RIGIDITY_SPLINE
    if wanted != NETWORK:
        return _joined(run, wanted, verb, found, note)
    rate, delay = found.filters.sample_rate, found.filters.delay
    networks = FollowingBank.of_networks(found.trained.networks, rate, delay)
    return _shipment(networks, wanted, panel, [path])


def _joined(
    run: Path, method: str, verb: str, compensation: Compensation | None = None, note: str = ""
) -> Shipment:
    """Join the filters of filters.h5 over temperature."""
    path = run_file(run, "filters.h5", verb)
    panel, focusing, _ = load_focusing(path)
    paths, feed = [path], None
    notes = [note] if note else []
    if method == RIGIDITY_SPLINE and compensation is not None:
        paths.append(run / "compensation.h5")
        feed = _rigidity(compensation, focusing.bank, path)
    if len(focusing.temperature) == 1:
        notes.append(f"{path}: filters of one temperature, {focusing.temperature[0]:g} °C; they follow none")
    kind = "linear" if method == LINEAR else "cubic"
    return _shipment(FollowingBank.of_filters(focusing.bank, kind, feed), method, panel, paths, notes)


def _rigidity(found: Compensation, bank: FirBank, path: Path) -> InputMap:
    feed = found.trained.networks.input
    low, high = feed.temperature_range
    if found.trained.settings.feed != "rigidity":
        raise ResultFileError(
            f"{path.parent}: {RIGIDITY_SPLINE} needs log √D over temperature, which compensation.h5 holds only "
            f"where its networks are fed with it: flexura compensate --feed rigidity, or take --method {SPLINE}"
        )
    if len(bank.temperature) == 1 or bank.temperature[0] < low - 1e-9 or bank.temperature[-1] > high + 1e-9:
        raise ResultFileError(
            f"{path}: filters from {bank.temperature[0]:g} to {bank.temperature[-1]:g} °C; those of "
            f"compensation.h5 beside it reach from {low:g} to {high:g} °C; make both again: flexura focus, "
            "flexura compensate"
        )
    return feed


def _shipment(
    filters: FollowingBank, method: str, panel: Panel, paths: list[Path], notes: Sequence[str] = ()
) -> Shipment:
    inputs = {path.name: sha256(path) for path in paths}
    made_from = provenance(inputs, {"method": method})
    made_from["made_from"] = {path.name: _stamp_of(path) for path in paths}
    names = tuple(patch.id for patch in panel.patch) or tuple(drive.id for drive in panel.drive)
    return Shipment(filters, method, names, panel, made_from, tuple(notes))


def _stamp_of(path: Path) -> dict[str, Any]:
    with result_file(path, "focus or flexura compensate") as file:
        return read_stamp(file)
