"""What of a run is exported: filters that follow the temperature, and where they come from."""

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from analysis.compensation.outcome import LINEAR, LOW_RANK, NETWORK, RIGIDITY_SPLINE, SPLINE, Compensation
from analysis.focusing.panel import Panel
from analysis.rendering.following import FollowingBank
from analysis.weather.family import TiltFamily
from analysis.weather.judged import WeatherJudgement
from app.files.bad_file import ResultFileError, UnsuitedOptionError
from app.files.hdf5_file import result_file
from app.files.provenance import provenance, read_stamp, sha256
from app.files.results.panel_files import load_compensation, load_focusing, other_filters
from app.files.results.run_folder import run_file

FORMAT = "flexura-filters/1"
"""Of all exports; a change that a reader would notice changes the number."""
METHODS = (NETWORK, LOW_RANK, SPLINE, RIGIDITY_SPLINE, LINEAR)
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
    family : TiltFamily or None
        What the filters add for tilted panels, where the run was judged in a weather.
    weather : WeatherJudgement or None
        This judgement.
    """

    filters: FollowingBank
    method: str
    names: tuple[str, ...]
    panel: Panel
    made_from: dict[str, Any]
    notes: tuple[str, ...] = ()
    family: TiltFamily | None = None
    weather: WeatherJudgement | None = None

    def in_weather(self) -> tuple[TiltFamily, WeatherJudgement]:
        """Return filters of the tilt and the weather they were judged in; ResultFileError without them."""
        if self.family is None or self.weather is None:
            raise ResultFileError(
                "--tilt: the run has no filters of the tilt; they are made with: flexura compensate --weather FILE"
            )
        return self.family, self.weather

    @property
    def stamp(self) -> str:
        """Format and provenance as JSON, in ASCII."""
        return json.dumps({"format": FORMAT} | self.made_from, allow_nan=False)

    def chosen(self, settings: dict[str, Any]) -> "Shipment":
        """Return the same with further settings in its provenance.

        Parameters
        ----------
        settings : dict
            Of values that JSON holds.
        """
        kept = self.made_from | {"settings": self.made_from["settings"] | settings}
        return replace(self, made_from=kept)


def shipment(run: Path, method: str | None, verb: str) -> Shipment:
    """Find the filters of a run folder.

    Parameters
    ----------
    run : Path
        With compensation.h5, filters.h5 or both.
    method : str, optional
        One of `METHODS`; left out, what ``flexura compensate`` recommends, or else a spline through the
        filters of ``flexura focus``.
    verb : str
        For messages.

    Raises
    ------
    ResultFileError
        Where the run holds no filters, or not those the method needs, and for an unknown method.
    """
    if method is not None and method not in METHODS:
        raise UnsuitedOptionError(f"--method {method!r}: allowed are {', '.join(METHODS)}")
    if not (run / "compensation.h5").is_file() and method not in (NETWORK, LOW_RANK, RIGIDITY_SPLINE):
        return _of_focusing(run, method or SPLINE, verb)
    path = run_file(run, "compensation.h5", verb)
    panel, found = load_compensation(path)
    wanted, notes = method or found.recommended, other_filters(run)
    if wanted not in METHODS:
        notes.append(f"{wanted}, recommended here, is no sum of fixed banks; {SPLINE} is taken in its place")
        wanted = SPLINE
    sent = _shipment(_of_compensation(found, wanted, path), wanted, panel, [path], notes)
    return replace(sent, family=found.family, weather=found.weather)


def _of_compensation(found: Compensation, method: str, path: Path) -> FollowingBank:
    bank = found.filters
    if method == NETWORK:
        return FollowingBank.of_networks(found.trained.networks, bank.sample_rate, bank.delay)
    if method == LOW_RANK:
        low = found.low_rank
        return FollowingBank.of_principal(
            low.temperature, low.coefficient, low.filters, low.mean, bank.sample_rate, bank.delay
        )
    if method != RIGIDITY_SPLINE:
        return FollowingBank.of_filters(bank, "linear" if method == LINEAR else "cubic")
    if found.trained.settings.feed != "rigidity":
        raise ResultFileError(
            f"{path}: {RIGIDITY_SPLINE} needs log √D over temperature, which it holds only where its networks are "
            f"fed with it: flexura compensate --feed rigidity, or take --method {SPLINE}"
        )
    return FollowingBank.of_filters(bank, feed=found.trained.networks.input)


def _of_focusing(run: Path, method: str, verb: str) -> Shipment:
    """Join the filters of filters.h5 over temperature."""
    path = run_file(run, "filters.h5", verb)
    panel, focusing, _ = load_focusing(path)
    notes = []
    if len(focusing.temperature) == 1:
        notes.append(f"{path}: filters of one temperature, {focusing.temperature[0]:g} °C; they follow none")
    filters = FollowingBank.of_filters(focusing.bank, "linear" if method == LINEAR else "cubic")
    return _shipment(filters, method, panel, [path], notes)


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
