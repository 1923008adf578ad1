"""A file of sound through filters that follow the temperature: to a file of one channel per actuator.

What the listeners of a panel hear of a piece of sound, written as it is rendered.
"""

import json
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from analysis.arrays import Complex, Real
from analysis.focusing.panel import Panel
from analysis.focusing.panel_model import constants_at
from analysis.material import MaterialLaws
from analysis.progress import Progress
from analysis.radiation.radiator import Radiator
from analysis.radiation.spherical_head import at_ears
from analysis.rendering.following import TemperatureProgramme
from analysis.rendering.renderer import (
    RESPONSE_SAMPLES,
    HeardRenderer,
    PanelResponse,
    Renderer,
    between_temperatures,
)
from analysis.weather.family import Across
from app.files.atomic import written_together
from app.files.bad_file import ResultFileError
from app.files.disk_room import RESULTS, require_room
from app.files.exports.shipment import Shipment
from app.files.sound_file import Sound, WavFile, WavFileError, create_wav
from app.sound.trace import Trace, WeatherOfPanel
from app.twins.panel_twin import PanelTwin

PARTS = ("heard", "heard-kept", "binaural", "binaural-kept")
"""Endings of the names of files: at the listeners and at two ears, filters that follow and the first ones."""


@dataclass(frozen=True)
class ListenersOfPanel:
    """The listeners of a panel, and the ears of the first one played to.

    Attributes
    ----------
    names : (L,) tuple of str
    head : str
        Name of the listener whose ears are meant.
    response : callable
        Pressure (L + 2, F, N), Pa/V, of a state of the panel and lines (F,), Hz: listeners, left ear, right ear.
        The state is the temperature, °C, or in a weather the time, s.
    panel : Panel
    weather : WeatherOfPanel, optional
        Which field of temperatures the panel has; else one temperature everywhere.
    """

    names: tuple[str, ...]
    head: str
    response: PanelResponse
    panel: Panel
    weather: WeatherOfPanel | None = None

    @classmethod
    def of(
        cls, twin: PanelTwin, panel: Panel, laws: MaterialLaws, weather: WeatherOfPanel | None = None
    ) -> "ListenersOfPanel":
        """Prepare the responses of a panel whose plate obeys laws.

        Parameters
        ----------
        laws : MaterialLaws
            Of the panel's plate.
        weather : WeatherOfPanel, optional
            Of this panel.

        Raises
        ------
        ValueError
            For a grid too coarse for the wavelength.
        """
        grid = twin.space.grid
        radiator = Radiator(grid.points, grid.area, panel.sound.air, panel.sound.mounting)
        radiator.require_fine(panel.filters.band[1], panel.shortest_wave(panel.filters.band[1]))
        places = np.array([one.position for one in panel.listeners])
        first = int(np.argmax(panel.loud))
        kernels: dict[int, Complex] = {}

        space = twin.space if weather is None else weather.twin.space

        def response(state: float, lines: Real) -> Complex:
            if len(lines) not in kernels:  # the lines are the same at every temperature
                kernel = radiator.pressure(places, lines)
                ears = at_ears(kernel[first], grid.points, places[first], radiator.wavenumber(lines))
                seen = np.concatenate([kernel, ears]) @ space.deflection
                kernels[len(lines)] = np.asarray(seen, dtype=complex)
            if weather is None:
                inside = float(np.clip(state, *laws.temperature_range))
                (constants,) = constants_at(laws, np.array([inside]))
                amplitude = twin.amplitudes(*constants, lines)
            else:
                amplitude = weather.amplitudes(state, lines)
            by_line = kernels[len(lines)].transpose(1, 2, 0)
            return np.asarray((amplitude.transpose(1, 0, 2) @ by_line).transpose(2, 0, 1), dtype=complex)

        names = tuple(one.name for one in panel.listeners)
        return cls(names, names[first], response, panel, weather)

    def state(self, time: float, temperature: float) -> float:
        """State of the panel, see `response`, at a time, s, and the temperature, °C, that the filters follow."""
        return temperature if self.weather is None else time

    def renderer(self, temperature: float) -> HeardRenderer:
        """Begin to render, the filters at a temperature, °C."""
        distance = between_temperatures if self.weather is None else self.weather.moved
        return HeardRenderer(self.response, self.panel.filters, self.state(0.0, temperature), distance)


@dataclass
class HeardFiles:
    """Files of the sound at the listeners, open to be written.

    Attributes
    ----------
    following, kept : HeardRenderer
        Of the drive by filters that follow, and by those of the first temperature.
    files : tuple of WavFile
        In the order of `PARTS`.
    loudest : float
        Largest pressure so far, Pa.
    """

    following: HeardRenderer
    kept: HeardRenderer
    files: tuple[WavFile, ...]
    loudest: float = 0.0

    @classmethod
    def opened(
        cls,
        stack: ExitStack,
        listeners: ListenersOfPanel,
        temperature: float,
        paths: tuple[Path, ...],
        drive: int,
        stamp: str,
    ) -> "HeardFiles":
        """Open the files.

        Parameters
        ----------
        stack : ExitStack
            Closes them.
        temperature : float
            Of the panel at first, °C.
        paths : tuple of Path
            In the order of `PARTS`.
        drive : int
            Samples of the drive.
        stamp : str
            JSON of the drive's origin.

        Raises
        ------
        WavFileError
            For more samples than a file can hold.
        """
        pair = listeners.renderer(temperature), listeners.renderer(temperature)
        rate, frames = listeners.panel.filters.sample_rate, drive + pair[0].ringing
        channels = (len(listeners.names), len(listeners.names), 2, 2)
        comment = json.dumps(json.loads(stamp) | {"unit": "Pa", "factor": 1.0})
        files = tuple(
            stack.enter_context(create_wav(path, rate, count, frames, comment))
            for path, count in zip(paths, channels, strict=True)
        )
        return cls(*pair, files)

    def take(self, followed: Real, kept: Real, state: float) -> None:
        """Write what is heard of a piece of drive.

        Parameters
        ----------
        followed, kept : (N, n) ndarray, V
            Of the filters that follow, and of the first ones.
        state : float
            Of the panel, see `ListenersOfPanel.state`.
        """
        self._write(0, self.following.take(followed, state))
        self._write(1, self.kept.take(kept, state))

    def finish(self) -> None:
        """Write what rings after the drive."""
        self._write(0, self.following.rest())
        self._write(1, self.kept.rest())

    def _write(self, which: int, parts: list[Real]) -> None:
        for part in parts:
            self.loudest = max(self.loudest, float(np.abs(part[:-2]).max(initial=0.0)))
            self.files[which].write(part[:-2])
            self.files[2 + which].write(part[-2:])


MOST_LOOKS = 60
"""Times that the field is looked at, at most, and once more at the end."""
LOOK_INTERVAL = 1.0
"""Seconds between two looks, at least."""


@dataclass(frozen=True)
class Rendering:
    """What came of a piece of sound.

    Attributes
    ----------
    sound, trace : Path
        WAV of one channel per actuator, in volts, and CSV of temperatures and contrast.
    seconds : float
        Of sound.
    changes : int
        Of the filters.
    largest : (N,) ndarray
        Largest value of each actuator, V or N.
    processing : float
        Seconds of processor time in filters and fades, in one thread.
    heard : tuple of Path
        WAV of the sound at the listeners and at two ears, in pascals (`app.sound.rendering.PARTS`); empty if not
        asked for.
    loudest : float
        Largest pressure at a listener, Pa.
    """

    sound: Path
    trace: Path
    seconds: float
    changes: int
    largest: Real
    processing: float
    heard: tuple[Path, ...] = ()
    loudest: float = 0.0

    @property
    def real_time_factor(self) -> float:
        """Seconds of sound to a second of processor time."""
        return self.seconds / max(self.processing, 1e-9)


def render(
    sound: Sound,
    shipment: Shipment,
    programme: TemperatureProgramme,
    folder: Path,
    block: int,
    trace: Trace,
    report: Progress = lambda _stage, _share: None,
    clock: Callable[[], float] = time.thread_time,
    listeners: ListenersOfPanel | None = None,
) -> Rendering:
    """Filter a file; both results are written whole, or not at all.

    Channels are averaged. The output is longer than the input by the taps, less one, so that nothing is cut off.

    Parameters
    ----------
    folder : Path
        Of the results.
    block : int
        Samples filtered at a time.
    trace : Trace
        Looks at the field meanwhile.
    report : callable, optional
        Called with the stage's name and the share done.
    clock : callable, optional
        Returns seconds; processor time of the thread by default.
    listeners : ListenersOfPanel, optional
        Whose sound is written, too.

    Raises
    ------
    ResultFileError
        For what is wrong with the sound, or a folder that cannot be written.
    """
    stem = f"{sound.path.stem}-rendered"
    names: tuple[str, ...] = (f"{stem}.wav", f"{stem}.csv")
    if listeners is not None:
        names += tuple(f"{sound.path.stem}-{part}.wav" for part in PARTS)
    first = float(programme.at(0.0))
    family = None if trace.weather is None else trace.weather.family
    work = _Work(Renderer(shipment.filters, first, block, family), clock)
    frames = sound.frames + shipment.filters.banks.shape[2] - 1
    actuators = len(shipment.filters.banks)
    channels = 0 if listeners is None else 2 * (len(listeners.names) + 2)
    require_room(folder, 4.0 * (actuators + channels) * (frames + RESPONSE_SAMPLES) + RESULTS, "--out")
    try:
        with written_together(folder, names) as (wav_path, trace_path, *heard_paths):
            with (
                ExitStack() as stack,
                create_wav(wav_path, sound.sample_rate, actuators, frames, shipment.stamp) as file,
            ):
                if listeners is not None:
                    kept = Renderer(shipment.filters, first, block)
                    files = HeardFiles.opened(stack, listeners, first, tuple(heard_paths), frames, shipment.stamp)
                    work.heard = (files, kept, listeners)
                work.whole(sound, programme, file, frames, trace, report)
            with trace_path.open("w", encoding="utf-8", newline="") as text:
                trace.write(text)
    except WavFileError as error:
        raise ResultFileError(f"{sound.path}: {error}") from error
    return Rendering(
        folder / names[0],
        folder / names[1],
        sound.seconds,
        work.renderer.changes,
        work.largest,
        work.processing,
        tuple(folder / name for name in names[2:]),
        0.0 if work.heard is None else work.heard[0].loudest,
    )


class _Work:
    """A renderer at work, its time taken."""

    def __init__(self, renderer: Renderer, clock: Callable[[], float]) -> None:
        self.renderer, self.clock = renderer, clock
        self.processing = 0.0
        self.largest = np.zeros(len(renderer.filters.banks))
        self.heard: tuple[HeardFiles, Renderer, ListenersOfPanel] | None = None

    def whole(
        self,
        sound: Sound,
        programme: TemperatureProgramme,
        file: WavFile,
        frames: int,
        trace: Trace,
        report: Progress,
    ) -> None:
        """Filter a whole file, and what rings after it."""
        block, written, looks = self.renderer.block, 0, 0
        spacing = max(LOOK_INTERVAL, sound.seconds / MOST_LOOKS)
        recent: list[Real] = []
        for samples in _padded(sound, block, frames):
            now = written / sound.sample_rate
            temperature = float(programme.at(now))
            across = (0.0, 0.0) if trace.weather is None else trace.weather.across(now)
            out = self._block(samples, temperature, across)[:, : frames - written]
            file.write(out)
            if self.heard is not None:
                files, kept, listeners = self.heard
                first = kept.process(samples)[:, : frames - written]
                files.take(out, first, listeners.state(now, temperature))
            written += out.shape[1]
            recent.append(samples)
            last = written - out.shape[1] < sound.frames <= written
            # None in the last half of an interval: the end itself is looked at, whatever the length is.
            if looks == 0 or looks * spacing <= now < sound.seconds - 0.5 * spacing or last:
                trace.look(now, temperature, self.renderer.temperature, np.concatenate(recent), self._tilt())
                recent, looks = [], looks + 1
                report("Sound", min(now / sound.seconds, 1.0))
        if self.heard is not None:
            self.heard[0].finish()
        report("Sound", 1.0)

    def _tilt(self) -> Real | None:
        """Return what is added to the filters' taps (N, M) for the tilt in use."""
        renderer = self.renderer
        return None if renderer.family is None else renderer.family.tilt(renderer.temperature, renderer.across)

    def _block(self, samples: Real, temperature: float, across: Across) -> Real:
        begun = self.clock()
        self.renderer.follow(temperature, across)
        out = self.renderer.process(samples)
        self.processing += self.clock() - begun
        self.largest = np.maximum(self.largest, np.abs(out).max(axis=1))
        return out


def _padded(sound: Sound, block: int, frames: int) -> Iterator[Real]:
    """Mean of the channels in whole blocks (block,), with silence behind, until `frames` samples are covered."""
    given = 0
    for channels in sound.blocks(block):
        mean = channels.mean(axis=0)
        given += block
        yield mean if len(mean) == block else np.concatenate([mean, np.zeros(block - len(mean))])
    while given < frames:
        given += block
        yield np.zeros(block)
