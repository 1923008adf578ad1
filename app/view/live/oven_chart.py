"""Temperatures against the programme, with the sweeps where they were made."""

import numpy as np
import pyqtgraph

from app.files.events import seconds
from app.view.chart import Chart
from app.view.theme import Theme
from app.watch.course import set_point_line
from app.watch.watched import Watched

MARKS = {"finished": "o", "rejected": "x", "missing": "t"}


class OvenChart(Chart):
    """Air, plate, set-point and programme over time.

    Parameters
    ----------
    theme : Theme
    """

    def __init__(self, theme: Theme) -> None:
        super().__init__("oven", "oven and plate against the programme", "time [min]", "temperature [°C]", theme)
        self.legend(columns=4, offset=(8, 4))
        self._programme = self.curve([], [], "programme", theme.muted, style="dash")
        self._set_point = self.curve([], [], "set-point", theme.corrected, width=1.4)
        self._air = self.curve([], [], "air", theme.identified, width=1.4)
        self._plate = self.curve([], [], "plate", theme.twin, width=2.0)
        self._asked = self._mark("asked for", "o", None, theme.muted)
        colors = {"finished": theme.measured, "rejected": theme.warning, "missing": theme.warning}
        self._marks = {
            kind: self._mark(kind, symbol, colors[kind], colors[kind]) for kind, symbol in MARKS.items()
        }

    def _mark(self, label: str, symbol: str, fill: str | None, edge: str) -> pyqtgraph.PlotDataItem:
        item = self.plot(
            [], [], pen=None, symbol=symbol, symbolSize=9, symbolBrush=fill, symbolPen=edge, name=label
        )
        item.opts["label"] = label
        return item

    def show_campaign(self, watched: Watched) -> None:
        """Draw all that is known."""
        if not watched.readings:
            return
        origin = seconds(watched.events[0]["date"]) if watched.events else seconds(watched.readings[0].date)

        def minutes(date: str) -> float:
            return (seconds(date) - origin) / 60.0

        time = np.array([minutes(reading.date) for reading in watched.readings])
        air = np.array([reading.air_c for reading in watched.readings])
        self._air.setData(time, air)
        self._plate.setData(time, np.array([reading.plate_c for reading in watched.readings]))
        commands = watched.events_of("oven")
        line = set_point_line(
            commands, [60.0 * minutes(c["date"]) for c in commands], 60.0 * time, air, 60.0 * float(time[-1])
        )
        self._set_point.setData(line[0] / 60.0, line[1], connect="finite")
        if (planned := watched.course) is not None:
            since, course = planned
            self._programme.setData((since - origin + course.time) / 60.0, course.temperature)
            self._asked.setData((since - origin + course.asked_at) / 60.0, course.asked)
        for kind, item in self._marks.items():
            happened = watched.events_of(kind)
            at = [minutes(event["date"]) for event in happened]
            item.setData(np.array(at), np.array([_temperature(watched, event) for event in happened]))


def _temperature(watched: Watched, event: dict[str, object]) -> float:
    if "temperature" in event:
        return float(str(event["temperature"]))
    if watched.protocol is not None:
        for leg in watched.protocol.legs:
            for point in leg.set_points:
                if point.step == event.get("step"):
                    return point.temperature
    return float("nan")
