"""What the listeners of a panel hear of a piece of sound, written as it is rendered."""

import json
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from analysis.arrays import Complex, Real
from analysis.focusing.panel import Panel
from analysis.focusing.responses import constants_at
from analysis.material import MaterialLaws
from analysis.radiation.radiator import Radiator
from analysis.radiation.spherical_head import at_ears
from analysis.rendering.heard import HeardRenderer, PanelResponse, between_temperatures
from app.files.sound_file import WavFile, create_wav
from app.sound.weather_of_panel import WeatherOfPanel
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
