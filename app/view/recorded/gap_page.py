"""Where twin and data disagree, and what each candidate alone would leave of it."""

from collections.abc import Mapping
from html import escape
from typing import Any

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QComboBox, QGridLayout, QLabel, QListWidget, QListWidgetItem, QVBoxLayout, QWidget

from analysis.arrays import Real
from app.files.results.gap_file import GapFigures, Signatures
from app.summaries.gap import (
    chi2_before_and_after,
    concluded,
    description_words,
    found_words,
    plan_words,
    titles_of,
)
from app.view.chart import Map
from app.view.cursors import FREQUENCY, TEMPERATURE, Cursors
from app.view.map_chart import MapChart
from app.view.theme import Theme, beyond_noise

Record = Mapping[str, Any]
LARGEST_COLOUR_SIGMA = 100.0
"""Sigma at which the colours end at the latest."""
TICKS = (1, 2, 3, 5, 10, 20, 50, 100)
"""Sigma at which the colour bar, whose scale is logarithmic, has numbers."""


class GapPage(QWidget):
    """Residual before and after, and the signatures of the candidates that are switched on.

    Parameters
    ----------
    figures : GapFigures
    signatures : Signatures or None
        None where there was no gap, and in files of earlier versions.
    record : mapping
        As in gap.json.
    cursors : Cursors
    theme : Theme
    """

    def __init__(
        self,
        figures: GapFigures,
        signatures: Signatures | None,
        record: Record,
        cursors: Cursors,
        theme: Theme,
    ) -> None:
        super().__init__()
        self._figures, self._signatures, self._cursors, self._theme = figures, signatures, cursors, theme
        self._channel = QComboBox()
        self._channel.addItems(list(figures.before.channels))
        self._before = MapChart("gap-before", "", FREQUENCY, TEMPERATURE, theme)
        self._after = MapChart("gap-after", "", FREQUENCY, TEMPERATURE, theme)
        self._signature = MapChart("gap-signatures", "", FREQUENCY, TEMPERATURE, theme)
        self.candidates = QListWidget()
        self._lay_out(record)
        self._draw()
        self._list(record)
        self._signature.setVisible(signatures is not None)
        self._channel.currentIndexChanged.connect(self._choose)
        self.candidates.itemChanged.connect(self._show_signatures)
        self._choose()

    def switch(self, effect: str, *, on: bool) -> None:
        """Switch the signature of a candidate on or off."""
        for place in range(self.candidates.count()):
            item = self.candidates.item(place)
            if item.data(Qt.ItemDataRole.UserRole) == effect:
                item.setCheckState(Qt.CheckState.Checked if on else Qt.CheckState.Unchecked)

    def _lay_out(self, record: Record) -> None:
        words, titles = concluded(record).capitalize(), titles_of(record)
        found = "".join(f"<li>{escape(found_words(effect, titles))}</li>" for effect in record["effects"])
        chi2 = " → ".join(chi2_before_and_after(record))
        label = QLabel(f"<h3>{words}</h3>χ² per degree of freedom {chi2}<ul>{found}</ul>{_further(record)}")
        label.setWordWrap(True)
        label.setObjectName("verdict")
        side = QVBoxLayout()
        side.addWidget(label)
        side.addWidget(QLabel("sensor"))
        side.addWidget(self._channel)
        side.addWidget(QLabel("what each effect alone would leave; switch it on or off:"))
        side.addWidget(self.candidates, stretch=1)
        grid = QGridLayout(self)
        grid.addWidget(self._before, 0, 0)
        grid.addWidget(self._after, 0, 1)
        grid.addWidget(self._signature, 1, 0)
        grid.addLayout(side, 1, 1)
        for place in (0, 1):
            grid.setRowStretch(place, 1)
            grid.setColumnStretch(place, 1)

    def _draw(self) -> None:
        top = float(np.clip(self._figures.before.sigma.max(), 3.0, LARGEST_COLOUR_SIGMA))
        ticks = [(float(np.log10(t)), f"{t}") for t in TICKS if t <= top]
        nothing = self._map(self._figures.before.sigma[:, 0])
        for chart in (self._before, self._after, self._signature):
            label = "rms residual [σ of the noise]"
            chart.image(nothing, beyond_noise(self._theme), (0.0, np.log10(top)), label, ticks)
        cursors = self._cursors

        def to_temperature(value: float) -> None:
            cursors.temperature = value

        def to_frequency(value: float) -> None:
            cursors.frequency = value

        for chart in (self._before, self._after, self._signature):
            chart.follow("x", cursors.frequency, cursors.frequency_moved, to_frequency)
            chart.follow("y", cursors.temperature, cursors.temperature_moved, to_temperature)
            if chart is not self._before:
                chart.setXLink(self._before)
                chart.setYLink(self._before)

    def _list(self, record: Record) -> None:
        taken = {effect["name"] for effect in record["effects"]}
        known = () if self._signatures is None else self._signatures.effects
        for row in sorted(record["candidates"], key=_evidence, reverse=True):
            share = " to first order" if row["share"] is None else f", explains {100 * row['share']:.1f} %"
            item = QListWidgetItem(f"{row['name']}: {max(_evidence(row), 0.0):,.0f} nats{share}")
            item.setData(Qt.ItemDataRole.UserRole, row["name"])
            if row["name"] in known:
                item.setFlags(item.flags() | Qt.ItemFlag.ItemIsUserCheckable)
                item.setCheckState(Qt.CheckState.Checked if row["name"] in taken else Qt.CheckState.Unchecked)
            self.candidates.addItem(item)

    @property
    def switched_on(self) -> list[str]:
        """Effects whose signatures are shown."""
        items = [self.candidates.item(place) for place in range(self.candidates.count())]
        return [
            str(item.data(Qt.ItemDataRole.UserRole))
            for item in items
            if item.flags() & Qt.ItemFlag.ItemIsUserCheckable and item.checkState() == Qt.CheckState.Checked
        ]

    def _choose(self) -> None:
        channel = self._channel.currentIndex()
        parts = (("before", self._before, self._figures.before), ("after", self._after, self._figures.after))
        for words, chart, seen in parts:
            chart.show_map(self._map(seen.sigma[:, channel]))
            chart.setTitle(f"{self._channel.currentText()}: what the twin misses, {words}")
        self._show_signatures()

    def _show_signatures(self) -> None:
        """Show in each cell what the best of the effects switched on would leave, alone."""
        on = self.switched_on
        if self._signatures is None:
            return
        left = [self._signatures.sigma[self._signatures.effects.index(name)] for name in on]
        best = np.min(left or [self._figures.before.sigma], axis=0)
        self._signature.show_map(self._map(best[:, self._channel.currentIndex()]))
        names = " or ".join(on) if len(on) < 3 else f"the best of {len(on)}"
        left_by = f"left by {names} alone" if on else "no effect is switched on"
        self._signature.setTitle(f"{self._channel.currentText()}: {left_by}")

    def _map(self, sigma: Real) -> Map:
        """Return the map of one channel's residual (T, B)."""
        before = self._figures.before
        temperature, grouped = before.grouped(sigma)
        middle = 0.5 * (before.edges[1:] + before.edges[:-1])
        return Map(middle, temperature, np.log10(np.maximum(grouped, 1.0)))


def _further(record: Record) -> str:
    """Say what an unknown cause acts like, and what to measure next, where these are known."""
    parts = (("", description_words(record)), ("Next: ", plan_words(record)))
    return "".join(f"<p>{escape(head + ' '.join(said))}</p>" for head, said in parts if said)


def _evidence(row: Record) -> float:
    fitted = row["log_evidence_fitted"]
    return float(row["log_evidence_screened"] if fitted is None else fitted)
