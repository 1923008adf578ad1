"""Measured modes beside those of the twin: the pairs, and the MAC of all of both."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QLabel, QVBoxLayout, QWidget

from app.summaries.modes import CAPTION, HEADINGS, likeness, point_rows, points_shown, rows, title
from app.view.map_chart import MacChart
from app.view.mode_table import ModeTable
from app.view.theme import Theme

Record = Mapping[str, Any]
SOURCES = {
    "modes.h5": "Measured modes: those of modes.h5.",
    "identified": "Measured modes: identified for this comparison; the run had no modes.h5 of flexura identify.",
}
BAND_MARGIN = 0.02
"""Share by which a mode of the twin may lie outside the frequencies of the measured ones and is still shown."""


class TwinPage(QWidget):
    """The modes of a sweep with those that the twin has, paired by frequency and residues.

    Parameters
    ----------
    record : mapping
        Of `app.files.results.pairing_json.pairing_record`.
    theme : Theme
    of : str
        What else has to be said of where the modes are from.
    before : str
        Which twin it is without the effects found, where there is one with them.
    """

    def __init__(self, record: Record, theme: Theme, of: str = "", before: str = "") -> None:
        super().__init__()
        self._sweeps: list[Record] = []
        self._twins: list[str] = []
        self.choice = QComboBox()
        without = f", {before}" if before else ""
        for name, words in (("sweeps_after", ", with the effects found"), ("sweeps", without)):
            for sweep in record[name] or ():
                self._sweeps.append(sweep)
                self._twins.append(words)
                self.choice.addItem(f"{sweep['temperature_c']:.1f} °C{words}")
        self.said, self.table = QLabel(), ModeTable((*HEADINGS, "MAC", "match"), range(len(HEADINGS) + 1))
        self.said.setWordWrap(True)
        self.table.setToolTip(CAPTION)
        self.alike = MacChart("twin-mac", "", "mode of the twin: f [Hz]", "measured mode: f [Hz]", theme)
        self._of = " ".join(filter(None, (of, SOURCES.get(record["measured_modes"], ""))))
        points = points_shown(record)
        self._lay_out(points)
        self.choice.currentIndexChanged.connect(self._show)
        self.choice.setCurrentIndex(record["shown"])  # of either list; those with effects stand first
        self._show()

    def _lay_out(self, points: Record | None) -> None:
        whole, row, left, right = QVBoxLayout(self), QHBoxLayout(), QVBoxLayout(), QVBoxLayout()
        whole.addWidget(self.said)
        whole.addLayout(row, stretch=1)
        row.addLayout(left, stretch=1)
        row.addLayout(right, stretch=1)
        left.addWidget(self.choice)
        left.addWidget(self.table, stretch=3)
        right.addWidget(self.alike, stretch=1)
        if points is None:
            return
        wrong = QLabel("\n".join(points["said"]) or "Points whose motion is least alike, over all pairs:")
        wrong.setWordWrap(True)
        left.addWidget(wrong)
        self.points = ModeTable(("point", "CoMAC", ""), (1,))
        self.points.show_rows(point_rows(points))
        left.addWidget(self.points, stretch=1)

    def _show(self) -> None:
        chosen = self.choice.currentIndex()
        sweep = self._sweeps[chosen]
        self.said.setText(f"{title(sweep)}{self._twins[chosen]}. {self._of}")
        kind = likeness(sweep)
        self.table.setHorizontalHeaderLabels([*HEADINGS, kind, "match"])
        self.table.show_rows(rows(sweep))
        found = sweep.get("mac")  # records of earlier versions have none
        if not found or not found["value"]:
            why = "one channel alone has no shape" if kind == "residues" else "run flexura update again for it"
            self.alike.setTitle(f"MAC of test and twin: {why}")
            return
        measured, computed = (np.array(found[name], float) for name in ("measured_hz", "computed_hz"))
        low, high = measured.min() * (1.0 - BAND_MARGIN), measured.max() * (1.0 + BAND_MARGIN)
        near = (computed >= low) & (computed <= high)
        paired = [pair["computed_hz"] for pair in sweep["pairs"]]
        shown = np.flatnonzero(near | np.isin(computed, paired))
        if not len(shown):
            self.alike.setTitle("MAC of test and twin: no mode of the twin is near")
            return
        self.alike.setTitle(f"how alike the shapes of test and twin are: MAC over {found['channels']} channels")
        self.alike.show_mac(
            np.array(found["value"], float)[:, shown],
            [f"{f:.1f}" for f in measured],
            [f"{f:.1f}" for f in computed[shown]],
        )
