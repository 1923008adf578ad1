"""Contrast of the simulated field along the way, beside that of filters that do not follow.

The field of temperatures of a panel while it plays, and what its thermometers tell the filters.
"""

import csv
from dataclasses import dataclass, field, replace
from typing import TextIO

import numpy as np

from analysis.arrays import Complex, Real
from analysis.focusing.energy import EnergyForms
from analysis.focusing.panel import Panel
from analysis.focusing.panel_model import constants_at
from analysis.material import MaterialLaws
from analysis.progress import Progress
from analysis.rendering.following import FollowingBank, TemperatureProgramme
from analysis.rendering.renderer import FieldContrast, field_contrast, power_spectrum
from analysis.weather.declared_weather import Weather
from analysis.weather.family import Across, TiltFamily, plane
from app.twins.panel_twin import PanelTwin
from app.twins.warm_twin import WarmTwin, temperatures, thermometer_places


@dataclass(frozen=True)
class WeatherOfPanel:
    """A panel in a weather: its field by the heat equation, a plane through its thermometers for the filters.

    Attributes
    ----------
    twin : WarmTwin
    time : (t,) ndarray, s
    temperature : (t, Q) ndarray, °C
        At the points of the twin.
    planes : (t, 3) ndarray
        Temperature in the middle, °C, and tilts along x and y, K, as the thermometers say.
    family : TiltFamily or None
        By which filters follow the tilt; without it they follow the middle alone.
    """

    twin: WarmTwin
    time: Real
    temperature: Real
    planes: Real
    family: TiltFamily | None

    @classmethod
    def of(
        cls, twin: WarmTwin, weather: Weather, origin: str, family: TiltFamily | None, report: Progress
    ) -> "WeatherOfPanel":
        """Solve the heat equation.

        Parameters
        ----------
        origin : str
            Name of the weather's file, for messages.
        report : callable
            Called with a stage's name and the share of it done.

        Raises
        ------
        ResultFileError
            Where a part of the plate leaves the laws.
        """
        found = temperatures(twin, weather, origin, report)
        places = thermometer_places(twin.panel.plate, weather)
        believed = [plane(places, readings) for readings in found.readings]
        planes = np.array([[one.middle, *one.across] for one in believed])
        return cls(twin, found.time, found.bending, planes, family)

    @property
    def programme(self) -> TemperatureProgramme:
        """Temperature in the middle over time, as the thermometers say."""
        return TemperatureProgramme(self.time, self.planes[:, 0])

    def across(self, time: float) -> Across:
        """Return the tilt along x and y, K, as the thermometers say, at a time, s."""
        x, y = (float(np.interp(time, self.time, column)) for column in self.planes.T[1:])
        return x, y

    def field(self, time: float) -> Real:
        """Temperatures (Q,), °C, at a time, s; the last ones after the weather."""
        later = min(int(np.searchsorted(self.time, time)), len(self.time) - 1)
        before = max(later - 1, 0)
        gap = float(self.time[later] - self.time[before])
        share = float(np.clip((time - self.time[before]) / gap, 0.0, 1.0)) if gap else 0.0
        now: Real = (1.0 - share) * self.temperature[before] + share * self.temperature[later]
        return now

    def moved(self, one: float, other: float) -> float:
        """Largest difference of temperature between two times, s, anywhere on the plate, K."""
        return float(np.abs(self.field(one) - self.field(other)).max())

    def amplitudes(self, time: float, lines: Real) -> Complex:
        """Generalised coordinates (N, F, r) of every actuator's field at a time, s, and lines (F,), Hz."""
        return self.twin.answer(self.field(time), lines).amplitude

    def forms(self, time: float, lines: Real) -> EnergyForms:
        """Energies of the actuators' fields at a time, s, and lines (F,), Hz."""
        return self.twin.space.forms([self.amplitudes(time, lines)], self.twin.panel.target.displacement)


HEADING = (
    "time_s",
    "temperature_c",
    "filters_c",
    "contrast_mean",
    "contrast_worst",
    "contrast_sound",
    "kept_mean",
    "kept_worst",
    "kept_sound",
)


@dataclass(frozen=True)
class TraceMoment:
    """One look at the field.

    Attributes
    ----------
    time : float
        s.
    temperature, filters : float
        Of the plate, and of the filters in use, degrees Celsius.
    following, kept : FieldContrast
        With the filters in use, and with those of the beginning.
    """

    time: float
    temperature: float
    filters: float
    following: FieldContrast
    kept: FieldContrast


@dataclass
class Trace:
    """The panel's twin, asked for its field at some moments of a piece of sound.

    Attributes
    ----------
    twin : PanelTwin
    panel : Panel
    laws : MaterialLaws
        Of the panel's plate.
    filters : FollowingBank
    weather : WeatherOfPanel, optional
        Which field of temperatures the panel has; else one temperature everywhere.
    moments : list of TraceMoment
    """

    twin: PanelTwin
    panel: Panel
    laws: MaterialLaws
    filters: FollowingBank
    weather: WeatherOfPanel | None = None
    moments: list[TraceMoment] = field(default_factory=list)

    def look(
        self, time: float, temperature: float, held: float, samples: Real, tilt: Real | None = None
    ) -> TraceMoment:
        """Judge the field of a piece of sound.

        Parameters
        ----------
        time : float
            When it is played, s.
        temperature : float
            Of the plate, degrees Celsius.
        held : float
            Temperature of the filters in use, degrees Celsius.
        samples : (n,) ndarray
            In any unit: only their spectrum's shape counts.
        tilt : (N, M) ndarray, optional
            What is added to the filters' taps in use for a tilted panel.

        Returns
        -------
        TraceMoment
            Also added to `moments`.
        """
        lines = self.panel.filters.frequency
        lines = lines[self.panel.filters.in_band(lines)]
        if self.weather is not None:
            forms = self.weather.forms(time, lines)
        else:
            (constants,) = constants_at(self.laws, np.array([temperature]))
            forms = self.twin.forms(*constants, lines, self.panel.target.displacement)
        spectrum = power_spectrum(samples, self.filters.sample_rate, lines)
        first = self.moments[0].filters if self.moments else held
        bank = self.filters.bank([held, first])
        if tilt is not None:
            bank = replace(bank, taps=bank.taps + np.array([tilt, np.zeros_like(tilt)]))
        used, kept = (field_contrast(forms, response, spectrum) for response in bank.response(lines))
        self.moments.append(TraceMoment(time, temperature, held, used, kept))
        return self.moments[-1]

    def write(self, file: TextIO) -> None:
        """Write the moments as CSV.

        Parameters
        ----------
        file : text file
            Open for writing.
        """
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(HEADING)
        for m in self.moments:
            shares = [f"{v:.6f}" for c in (m.following, m.kept) for v in (c.mean, c.worst, c.sound)]
            rows.writerow([f"{m.time:.3f}", f"{m.temperature:.4f}", f"{m.filters:.4f}", *shares])
