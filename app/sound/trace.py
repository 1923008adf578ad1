"""Contrast of the simulated field along the way, beside that of filters that do not follow."""

import csv
from dataclasses import dataclass, field, replace
from typing import TextIO

import numpy as np

from analysis.arrays import Real
from analysis.focusing.panel import Panel
from analysis.focusing.responses import constants_at
from analysis.material import MaterialLaws
from analysis.rendering.following import FollowingBank
from analysis.rendering.heard import FieldContrast, field_contrast, power_spectrum
from app.sound.weather_of_panel import WeatherOfPanel
from app.twins.panel_twin import PanelTwin

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
