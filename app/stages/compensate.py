"""Compensate stage: networks and other methods that predict a panel's filters over temperature, compared."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from analysis.compensation.outcome import Compensation
from analysis.compensation.settings import Training, suited_nodes
from analysis.compensation.study import compensate, compensate_measured
from analysis.compensation.tilted import tilted_contrast
from analysis.focusing.measured import MeasuredPanel
from analysis.focusing.methods import Method
from analysis.focusing.panel import Panel
from analysis.focusing.panel_model import covered, spaced
from analysis.material import MaterialLaws
from analysis.progress import Progress
from analysis.recordings.campaign import CampaignExtent
from analysis.weather.declared_weather import Weather
from analysis.weather.family import FieldDesign, TiltFamily, plane
from analysis.weather.judged import WeatherFields, judge_weather
from app.files.campaigns.inputs import extent_settings
from app.files.provenance import provenance
from app.files.results.panel_files import save_compensation
from app.stages.panel.inputs import workers
from app.summaries.table import as_text
from app.twins.panel_twin import panel_twin

if TYPE_CHECKING:
    from app.twins.warm_twin import WarmTwin

COMPENSATION = "compensation.h5"
FAMILY_SPACING = 5.0
"""Largest spacing of the temperatures at which filters of tilted panels are designed, K."""
WEATHER_SEED = 48
"""Of the noise of the panel's own response in a weather."""
GOOD_LOSS = 0.02
"""Largest loss of contrast of networks against directly computed filters, at any line and temperature."""


@dataclass(frozen=True)
class CompensatedPanel:
    """Result of the compensate stage.

    Attributes
    ----------
    panel : Panel
    compensation : Compensation
        Networks and other methods, with the performance of each.
    spacing : float or None
        Spacing of training temperatures, K; None where they were placed, or measured.
    device : str
        Device on which the networks were trained.
    measured : bool
        Whether the filters come from measured transfers; otherwise from laws and a twin.
    notes : tuple of str
        Where the laws come from, and what of the measured plate the panel has.
    weather : Weather or None
        In which filters were judged.
    """

    panel: Panel
    compensation: Compensation
    spacing: float | None
    device: str
    measured: bool = False
    notes: tuple[str, ...] = ()
    weather: Weather | None = None

    def __repr__(self) -> str:
        """Training temperatures, loss of contrast and recommended method in one line, and the notes."""
        found = self.compensation
        t, loss = found.temperature, found.largest_loss
        line = (
            f"CompensatedPanel: {len(found.training_temperature)} training temperatures, {t[0]:g} to {t[-1]:g} "
            f"°C: the networks lose at most {loss[0]:.2g} of contrast; recommended: {found.recommendation}"
        )
        return as_text(line, self.notes)


def compute(
    panel: Panel,
    laws: MaterialLaws,
    report: Progress,
    *,
    training: Training | None = None,
    spacing: float = 5.0,
    method: Method = "stif",
    device: str = "cpu",
    place: int | None = None,
    across: Sequence[float] = (),
    weather: tuple[Weather, str] | None = None,
    notes: Sequence[str] = (),
) -> CompensatedPanel:
    """Build the panel's twin, train one network per actuator, and compare all methods.

    Parameters
    ----------
    laws : MaterialLaws
        As measured; thermal expansion of the panel's plate is added here.
    report : callable
        Called with a stage's name and the share of it done.
    training : Training, optional
        By default the standard settings, with fewer hidden nodes for few placed temperatures.
    spacing : float
        Spacing of training temperatures, K.
    method : str
        Design method of the filters that the networks predict.
    device : str
        Where they are trained: ``cpu``, or a device of torch, ``cuda``, ``cuda:1``.
    place : int, optional
        Number of training temperatures, placed by need instead of every `spacing`.
    across : sequence of float
        Differences of temperature between two opposite sides of the panel, K, for which contrast is computed.
    weather : (Weather, str), optional
        In which filters are judged, and the name of its file.
    notes : sequence of str
        Of the laws' origin, kept in the result.

    Raises
    ------
    EvidenceCollapseError
        Where a network is refused.
    ResultFileError
        Where the weather takes the plate out of the laws.
    ValueError
        Where the common range of laws and panel is empty, has fewer than four training temperatures, or is
        narrower than a difference `across`.
    """
    laws = panel.plate.grown(laws)
    low, high = covered(laws, panel.filters.operating_range)
    model = panel_twin(panel, laws, report)
    warm = None
    if across or weather is not None:
        from app.twins.warm_twin import warm_twin  # slow import: mesher and assembly

        warm = warm_twin(panel, laws, report)
    fields = None
    if warm is not None and weather is not None:  # before the networks: what leaves the laws is told at once
        from app.twins.warm_twin import weather_fields

        fields = weather_fields(warm, *weather, report)
    found = compensate(
        model,
        panel,
        laws,
        spacing,
        training or (Training() if place is None else Training(nodes=suited_nodes(place))),
        _clock(device),
        device=device,
        report=report,
        method=method,
        workers=workers(),
        place=place,
    )
    if warm is not None and across:
        networks = found.trained.networks.taps
        found = replace(
            found, tilted=tilted_contrast(warm, panel, found.filters, networks, across, (low, high), report)
        )
    if warm is not None and fields is not None:
        found = _in_weather(found, warm, fields, spacing, report)
    return CompensatedPanel(
        panel,
        found,
        spacing if place is None else None,
        device,
        notes=tuple(notes),
        weather=None if weather is None else weather[0],
    )


def _in_weather(
    found: Compensation, warm: "WarmTwin", fields: WeatherFields, spacing: float, report: Progress
) -> Compensation:
    """Judge filters in a weather, with a family of tilts as wide as the thermometers of the weather see."""
    panel, limits = warm.panel, warm.laws.temperature_range
    design = FieldDesign.of(warm, panel, found.filters.delay)
    planes = [plane(fields.places, readings).across for readings in fields.readings]
    across = max(1.0, float(np.abs(planes).max()))
    knots = spaced(*covered(warm.laws, panel.filters.operating_range), min(spacing, FAMILY_SPACING))
    family = TiltFamily.of(design, knots, min(across, limits[1] - limits[0]), limits, report)
    judged = judge_weather(design, family, fields, limits, np.random.default_rng(WEATHER_SEED), report)
    return replace(found, weather=judged, family=family)


def compute_measured(
    measured: MeasuredPanel,
    report: Progress,
    *,
    training: Training | None = None,
    method: Method = "stif",
    device: str = "cpu",
) -> CompensatedPanel:
    """Train one network per actuator on filters of measured transfers, and compare all methods without a twin.

    Parameters
    ----------
    report : callable
        Called with a stage's name and the share of it done.
    training : Training, optional
        By default the standard settings, with fewer hidden nodes for few temperatures.
    method : str
        Design method of the filters that the networks predict.
    device : str
        Where they are trained: ``cpu``, or a device of torch, ``cuda``, ``cuda:1``.

    Raises
    ------
    EvidenceCollapseError
        Where a network is refused.
    ValueError
        For transfers at fewer than five temperatures.
    """
    training = training or Training(nodes=suited_nodes(len(measured.transfers.temperature), measured=True))
    found = compensate_measured(measured, training, _clock(device), device, report, method, workers())
    return CompensatedPanel(measured.panel, found, None, device, measured=True)


def _clock(device: str) -> Callable[[], float]:
    """Clock for timing methods: the thread's processor time on the processor, wall time on other devices."""
    return time.thread_time if device == "cpu" else time.perf_counter


def save(
    run: Path, found: CompensatedPanel, inputs: Mapping[str, str], extent: CampaignExtent | None = None
) -> Path:
    """Write compensation.h5.

    Parameters
    ----------
    run : Path
        Run folder.
    inputs : mapping
        SHA-256 of every input file of the networks, by its name.
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
    target, outcome = run / COMPENSATION, found.compensation
    settings = {
        "spacing": found.spacing,
        "place": None if outcome.placed is None else len(outcome.placed.temperature),
        "across": [] if outcome.tilted is None else outcome.tilted.difference.tolist(),
        "weather": None if found.weather is None else found.weather.model_dump(mode="json"),
        "method": outcome.focusing,
        "device": found.device,
        "panel": found.panel.model_dump(mode="json"),
        "measured": found.measured,
        **extent_settings(extent),
    }
    save_compensation(target, found.panel, outcome, provenance(inputs, settings, outcome.trained.settings.seed))
    return target
