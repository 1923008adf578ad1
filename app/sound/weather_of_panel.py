"""The field of temperatures of a panel while it plays, and what its thermometers tell the filters."""

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Complex, Real
from analysis.focusing.energy import EnergyForms
from analysis.progress import Progress
from analysis.rendering.following import TemperatureProgramme
from analysis.weather.declared_weather import Weather
from analysis.weather.family import Across, TiltFamily
from analysis.weather.knowledge import plane
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
