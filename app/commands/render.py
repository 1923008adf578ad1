"""``flexura render``: sound filtered with temperature-dependent filters."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from app.commands.bad_input import bad_input
from app.commands.options import (
    RUN_WITH_FILTERS,
    SOUND,
    WEATHER,
    following_method,
    laws_of_twin,
    out_folder,
    picture,
)
from app.commands.output import Output, output_options

if TYPE_CHECKING:
    from analysis.focusing.panel import Panel
    from analysis.material import MaterialLaws
    from analysis.progress import Progress
    from analysis.rendering.programme import TemperatureProgramme
    from analysis.weather.declared_weather import Weather
    from app.files.exports.shipment import Shipment
    from app.sound.listeners import ListenersOfPanel
    from app.sound.rendering import Rendering
    from app.sound.trace import Trace
    from app.sound.weather_of_panel import WeatherOfPanel
    from app.twins.panel_twin import PanelTwin


EXAMPLES = """\b
Examples:
  flexura render music.wav plate-run --temperature 20:45
  flexura render music.wav plate-run --temperature 20:60 --heard
  flexura render music.flac plate-run --temperature readings.csv --method network
  flexura render music.flac plate-run --weather examples/warming-car.toml
"""


@click.command(name="render", epilog=EXAMPLES, short_help="Play a sound file through the filters.")
@click.argument("sound", type=SOUND)
@click.argument("run", type=RUN_WITH_FILTERS, required=False)
@click.option(
    "--temperature",
    metavar="T[:T...]|FILE",
    help="°C: one, a way between several over the sound, or a CSV file of seconds and °C.",
)
@click.option(
    "--weather",
    type=WEATHER,
    help="A weather's file (*.toml) in place of --temperature: filters follow its thermometers.",
)
@following_method
@click.option(
    "--block",
    type=click.IntRange(16, 65_536),
    default=512,
    show_default=True,
    help="Samples filtered at a time, after which a new temperature is heeded.",
)
@click.option("--heard", is_flag=True, help="Write the sound at the panel's listeners, too, and at two ears.")
@picture
@laws_of_twin
@out_folder("Folder for the results (default: RUN).")
@output_options("contrast along the way and the real-time factor")
@bad_input
def command(
    sound: Path,
    run: Path | None,
    temperature: str | None,
    weather: Path | None,
    method: str | None,
    block: int,
    heard: bool,
    picture: bool,
    twin: Path | None,
    out: Path | None,
    output: Output,
) -> None:
    """Filter SOUND as the panel of RUN would be driven while its temperature moves.

    SOUND is WAV, FLAC or what else libsndfile reads, at the sample rate of the filters; channels are averaged. RUN
    is a run folder with laws.h5 and filters.h5 or compensation.h5 (default: the current folder). Writes
    SOUND-rendered.wav, one channel per actuator in volts, and SOUND-rendered.csv: temperature and contrast of the
    twin's field along the way, with the filters in use and with those of the beginning kept. --heard computes the
    sound at the listeners of the panel's file, in pascals, as WAV: SOUND-heard.wav, one channel per listener, and
    SOUND-binaural.wav, at the ears of the first (a rigid sphere for a head); SOUND-heard-kept.wav and
    SOUND-binaural-kept.wav with the filters of the beginning kept. With --weather, the panel has the field of
    temperatures that the heat equation gives it, from the beginning of the sound on; filters follow the plane
    through the thermometers, and its tilt too if flexura compensate --weather made filters for it.
    """
    if (temperature is None) == (weather is None):
        raise click.UsageError("name one of --temperature and --weather: what the panel's temperature does")
    if heard and weather is not None:
        raise click.UsageError("--heard is of a panel with one temperature: leave out --heard or --weather")

    from app.files.exports.shipment import shipment
    from app.files.provenance import sha256
    from app.files.run_folder import run_folder
    from app.files.weather_file import read_weather
    from app.stages.panel_laws import laws_for
    from app.summaries.campaign_extent import led

    given = run or Path()
    asked = {"sound": sound.name, "temperature": temperature}
    declared = None
    if weather is not None:
        declared, asked["weather"] = read_weather(weather), sha256(weather)
    sent = shipment(given, method, "render").chosen(asked)
    origin = laws_for(given, twin, "render")
    laws = sent.panel.plate.grown(origin.laws)

    from app.files.sound_file import opened_sound
    from app.sound.rendering import render
    from app.sound.temperatures import programme
    from app.sound.trace import Trace
    from app.twins.panel_twin import panel_twin
    from app.twins.weather_fields import check_thermometers

    with opened_sound(sound, sent.filters.sample_rate) as opened:
        if temperature is not None:
            course = programme(temperature, opened.seconds)
            covered(sent, laws, course)
        if declared is not None:
            check_thermometers(sent.panel.plate, declared, str(weather))
        with run_folder(given, out or given) as folder, output.progress() as report:
            model = panel_twin(sent.panel, laws, report)
            around = None
            if declared is not None:
                around = weather_of_panel(sent, laws, declared, str(weather), report)
                course = around.programme
            trace = Trace(model, sent.panel, laws, sent.filters, around)
            listeners = listening(model, sent.panel, laws) if heard else None
            done = render(opened, sent, course, folder, block, trace, report, listeners=listeners)
        channels = opened.channels
    if picture:
        from app.report.sound import along_the_way
        from app.report.style import saved

        saved(done.trace.with_suffix(".png"), lambda: along_the_way(trace.moments))
    output.result(lambda: record(sent, done, trace, block))
    for note in (
        *origin.notes,
        *sent.notes,
        *notes(channels, trace),
        *beyond_rated(sent, done),
        *told(sent, done),
        *weathered(sent, trace, done.seconds),
    ):
        output.note(note)
    output.summary(f"{led(origin.extent)}{summary(sent, done, trace)}")


def weather_of_panel(
    sent: "Shipment", laws: "MaterialLaws", weather: "Weather", origin: str, report: "Progress"
) -> "WeatherOfPanel":
    """Return the panel's field of temperatures over time, and what its thermometers tell.

    Parameters
    ----------
    laws : MaterialLaws
        Of the panel's plate.
    origin : str
        Name of the weather's file.
    report : callable
        Called with a stage's name and the share of it done.

    Raises
    ------
    ResultFileError
        Where a part of the plate leaves the laws.
    """
    from app.sound.weather_of_panel import WeatherOfPanel
    from app.twins.warm_twin import warm_twin

    return WeatherOfPanel.of(warm_twin(sent.panel, laws, report), weather, origin, sent.family, report)


def weathered(sent: "Shipment", trace: "Trace", seconds: float) -> list[str]:
    """Say what of the weather was played and what the filters followed; nothing without a weather.

    Parameters
    ----------
    seconds : float
        Of sound.
    """
    around = trace.weather
    if around is None:
        return []
    length = float(around.time[-1])
    part = f"; the sound ends after {seconds:.0f} of {length:g} s of the weather" if seconds < length else ""
    if sent.family is None:
        followed = "the middle of the panel only; flexura compensate --weather makes filters that follow its tilt"
    else:
        followed = f"the middle of the panel and its tilt, up to {sent.family.across:.1f} K"
    return [f"filters follow {followed}{part}"]


def listening(model: "PanelTwin", panel: "Panel", laws: "MaterialLaws") -> "ListenersOfPanel":
    """Return the listeners of a panel.

    Parameters
    ----------
    laws : MaterialLaws
        Of the panel's plate.

    Raises
    ------
    ResultFileError
        For a grid too coarse for the wavelength.
    """
    from app.files.bad_file import ResultFileError
    from app.sound.listeners import ListenersOfPanel

    try:
        return ListenersOfPanel.of(model, panel, laws)
    except ValueError as error:
        raise ResultFileError(f"--heard: the panel's grid: {error}") from error


def told(sent: "Shipment", done: "Rendering") -> list[str]:
    """Say what is in the files of the sound at the listeners; nothing where there are none."""
    if not done.heard:
        return []
    names = ", ".join(one.name for one in sent.panel.listeners)
    low, high = sent.panel.filters.edges
    level = 20.0 * math.log10(max(done.loudest, 1e-9) / math.sqrt(2.0) / 2e-5)
    return [
        f"{done.heard[0].name}: pascals (1 Pa per unit) at {names}, up to {done.loudest:.3g} Pa, "
        f"{level:.0f} dB SPL of a sine as large; known from {low:g} to {high:g} Hz; "
        f"{done.heard[2].name}: at the ears of a rigid sphere that looks straight at the panel's plane"
    ]


def covered(sent: "Shipment", laws: "MaterialLaws", course: "TemperatureProgramme") -> None:
    """Raise ResultFileError unless filters and laws cover all temperatures.

    Parameters
    ----------
    laws : MaterialLaws
        Of the panel's plate.

    Raises
    ------
    ResultFileError
        Where the temperature leaves what one of them covers.
    """
    from app.files.bad_file import ResultFileError

    held = sent.filters.input.temperature_range
    if sent.filters.weights.count == 1:  # one filter for all temperatures; its panel's range counts
        held = sent.panel.filters.operating_range
    for what, (low, high) in (("filters", held), ("laws", laws.temperature_range)):
        outside = course.temperature[(course.temperature < low - 1e-9) | (course.temperature > high + 1e-9)]
        if outside.size:
            raise ResultFileError(
                f"--temperature {outside[0]:g} °C is outside what the {what} cover, {low:g} to {high:g} °C"
            )


def record(sent: "Shipment", done: "Rendering", trace: "Trace", block: int) -> dict[str, Any]:
    """Return what ``--json`` prints; null for a contrast of silence.

    Parameters
    ----------
    block : int
        Samples per block, which add to the latency.

    Returns
    -------
    dict
        Of JSON values.
    """
    return {
        "sound": str(done.sound),
        "trace": str(done.trace),
        "heard": [str(path) for path in done.heard],
        "loudest_pa": done.loudest,
        "method": sent.method,
        "seconds": done.seconds,
        "changes": done.changes,
        "largest_v": dict(zip(sent.names, done.largest.tolist(), strict=True)),
        "rated_v": {
            name: rated if math.isfinite(rated) else None
            for name, rated in zip(sent.names, sent.panel.limits.tolist(), strict=True)
        },
        "latency_samples": block + sent.filters.delay,
        "processing_seconds": done.processing,
        "real_time_factor": done.real_time_factor,
        "moments": [
            {
                "time_s": m.time,
                "temperature_c": m.temperature,
                "filters_c": m.filters,
                "contrast_mean": m.following.mean,
                "contrast_worst": m.following.worst,
                "contrast_sound": None if m.following.sound != m.following.sound else m.following.sound,
                "kept_mean": m.kept.mean,
            }
            for m in trace.moments
        ],
    }


def notes(channels: int, trace: "Trace") -> list[str]:
    """Return notes on the sound."""
    found = [] if channels == 1 else [f"the mean of its {channels} channels is played"]
    silent = sum(m.following.sound != m.following.sound for m in trace.moments)
    if silent:
        found.append(f"at {silent} of {len(trace.moments)} moments the sound is silent in the panel's band")
    return found


def beyond_rated(sent: "Shipment", done: "Rendering") -> list[str]:
    """Return a note where an actuator would get more volts than it is rated for: audio beyond ±1 can do that."""
    shares = done.largest / sent.panel.limits
    worst = int(shares.argmax())
    if shares[worst] <= 1.0:
        return []
    volts, rated = done.largest[worst], sent.panel.limits[worst]
    return [
        f"{sent.names[worst]} would get {volts:.4g} V; it is rated for {rated:.4g} V: play this sound at "
        f"{rated / volts:.3f} of its level or less (the filters are made for audio within ±1)"
    ]


def summary(sent: "Shipment", done: "Rendering", trace: "Trace") -> str:
    """Return one line for people.

    Parameters
    ----------
    trace : Trace
        With at least one moment.
    """
    t = [m.temperature for m in trace.moments]
    used, kept = ([m.mean for m in way] for way in _ways(trace))
    return (
        f"{done.seconds:.1f} s at {min(t):.1f} to {max(t):.1f} °C, {done.changes} changes of the filters "
        f"({sent.method}): contrast {min(used):.3f} to {max(used):.3f}, with the first filters kept down to "
        f"{min(kept):.3f}; up to {done.largest.max():.3g} V; {done.real_time_factor:.0f} times real time on one "
        f"core; {done.sound}"
    )


def _ways(trace: "Trace") -> tuple[list[Any], list[Any]]:
    return [m.following for m in trace.moments], [m.kept for m in trace.moments]
