"""Render stage: sound filtered as a panel would be driven while its temperature moves."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from analysis.focusing.panel import Panel
from analysis.material import MaterialLaws
from analysis.progress import Progress
from analysis.recordings.campaign import CampaignExtent
from analysis.weather.declared_weather import Weather
from app.files.bad_file import ResultFileError, UnsuitedOptionError
from app.files.declarations.panel import read_weather
from app.files.exports.shipment import Shipment, shipment
from app.files.provenance import sha256
from app.files.results.run_folder import run_folder
from app.files.sound_file import opened_sound
from app.sound import said_of_rendering as said
from app.sound.temperatures import programme, require_covered
from app.stages.panel.laws import laws_for
from app.summaries.numbers import led

if TYPE_CHECKING:
    from app.sound.rendering import ListenersOfPanel, Rendering
    from app.sound.trace import Trace, WeatherOfPanel
    from app.twins.panel_twin import PanelTwin

USUAL_BLOCK, SMALLEST_BLOCK, LARGEST_BLOCK = 512, 16, 65_536
"""Samples filtered at a time: by default as many as sound cards ask for, at 8 kHz 64 ms."""


@dataclass(frozen=True, kw_only=True)
class RenderRequest:
    """A piece of sound, and what the panel's temperature does meanwhile.

    Attributes
    ----------
    sound : Path
    run : Path
        Run folder with laws.h5 and filters.h5 or compensation.h5.
    temperature : str or None
        Degrees Celsius: one, a way between several over the sound, or a CSV file of seconds and degrees.
    weather : Path or None
        A weather's file in place of a temperature.
    method : str or None
        How filters follow the temperature; what ``flexura compensate`` recommends where it is None.
    block : int
        Samples filtered at a time.
    heard : bool
        Whether the sound at the panel's listeners is written, too.
    twin : Path or None
        Twin file whose laws are taken.
    """

    sound: Path
    run: Path
    temperature: str | None = None
    weather: Path | None = None
    method: str | None = None
    block: int = USUAL_BLOCK
    heard: bool = False
    twin: Path | None = None

    def __post_init__(self) -> None:
        """Raise UnsuitedOptionError for options that exclude each other."""
        if (self.temperature is None) == (self.weather is None):
            raise UnsuitedOptionError("name one of --temperature and --weather: what the panel's temperature does")
        if not SMALLEST_BLOCK <= self.block <= LARGEST_BLOCK:
            allowed = f"{SMALLEST_BLOCK} to {LARGEST_BLOCK}"
            raise UnsuitedOptionError(f"--block {self.block}: allowed are {allowed} samples")


@dataclass(frozen=True)
class RenderedSound:
    """Result of the render stage.

    Attributes
    ----------
    shipment : Shipment
        Filters and panel.
    rendering : Rendering
        The files, and what was measured while they were made.
    trace : Trace
        The twin's field along the way.
    block : int
        Samples filtered at a time.
    extent : CampaignExtent or None
        Of the campaign that the laws come from.
    notes : tuple of str
        For people.
    """

    shipment: Shipment
    rendering: "Rendering"
    trace: "Trace"
    block: int
    extent: CampaignExtent | None = None
    notes: tuple[str, ...] = field(default=(), repr=False)

    def record(self) -> dict[str, Any]:
        """Return what ``--json`` prints; null for a contrast of silence."""
        return said.record(self.shipment, self.rendering, self.trace.moments, self.block)

    def __repr__(self) -> str:
        """Say in one line what the panel did."""
        return f"{led(self.extent)}{said.summary(self.shipment, self.rendering, self.trace.moments)}"


def compute(request: RenderRequest, out: Path, report: Progress) -> RenderedSound:
    """Filter a piece of sound; all of its files are written whole, or none.

    Parameters
    ----------
    request : RenderRequest
    out : Path
        Folder for the files.
    report : callable
        Called with a stage's name and the share of it done.

    Raises
    ------
    ResultFileError
        For a run, a sound or a weather that cannot be used, and temperatures outside what laws or filters cover.
    """
    asked = {"sound": request.sound.name, "temperature": request.temperature}
    declared = None
    if request.weather is not None:
        declared, asked["weather"] = read_weather(request.weather), sha256(request.weather)
    sent = shipment(request.run, request.method, "render").chosen(asked)
    origin = laws_for(request.run, request.twin, "render")
    laws = sent.panel.plate.grown(origin.laws)

    from app.sound.rendering import render
    from app.sound.trace import Trace
    from app.twins.panel_twin import panel_twin
    from app.twins.warm_twin import check_thermometers

    with opened_sound(request.sound, sent.filters.sample_rate) as sound:
        if request.temperature is not None:
            course = programme(request.temperature, sound.seconds)
            require_covered(sent, laws, course)
        if declared is not None:
            check_thermometers(sent.panel.plate, declared, str(request.weather))
        with run_folder(request.run, out) as folder:
            model = panel_twin(sent.panel, laws, report)
            around = None
            if declared is not None:
                around = _weather_of(sent, laws, declared, str(request.weather), report)
                course = around.programme
            trace = Trace(model, sent.panel, laws, sent.filters, around)
            listeners = _listening(model, sent.panel, laws, around) if request.heard else None
            done = render(sound, sent, course, folder, request.block, trace, report, listeners=listeners)
        channels = sound.channels
    notes = (
        *origin.notes,
        *sent.notes,
        *said.notes(channels, trace.moments),
        *said.beyond_rated(sent, done),
        *said.heard_at(sent, done),
        *(() if around is None else said.followed(sent, float(around.time[-1]), done.seconds)),
    )
    return RenderedSound(sent, done, trace, request.block, origin.extent, notes)


def _weather_of(
    sent: Shipment, laws: MaterialLaws, weather: Weather, origin: str, report: Progress
) -> "WeatherOfPanel":
    """Return the panel's field of temperatures over time, and what its thermometers tell."""
    from app.sound.trace import WeatherOfPanel
    from app.twins.warm_twin import warm_twin

    return WeatherOfPanel.of(warm_twin(sent.panel, laws, report), weather, origin, sent.family, report)


def _listening(
    model: "PanelTwin", panel: Panel, laws: MaterialLaws, around: "WeatherOfPanel | None"
) -> "ListenersOfPanel":
    from app.sound.rendering import ListenersOfPanel

    try:
        return ListenersOfPanel.of(model, panel, laws, around)
    except ValueError as error:  # a grid too coarse for the wavelength
        raise ResultFileError(f"--heard: the panel's grid: {error}") from error
