"""Modes of two runs side by side: MAC of all pairs, and what has changed from one to the other."""

import numpy as np
from PySide6.QtWidgets import QHBoxLayout, QLabel, QVBoxLayout, QWidget

from analysis.arrays import Complex
from analysis.estimation.transfer import along_axis, direction_sign
from analysis.shapes.participation import mac
from app.modal_test.modes_of_test import mode_names
from app.view.map_chart import MacChart
from app.view.mode_table import ModeTable
from app.view.test_run.held import HeldTest
from app.view.theme import Theme

HEADINGS = ("f [Hz]", "f there [Hz]", "Δf [%]", "ζ [%]", "ζ there [%]", "MAC")
LEAST_COMMON = 2
"""Places that both runs must share: one place alone has no shape."""
LEAST_PAIRED_MAC = 0.5
"""MAC from which two modes are set side by side."""


class ComparedPage(QWidget):
    """The modes of a run with those of another one that are most like them.

    Parameters
    ----------
    held, other : HeldTest
    theme : Theme
    """

    def __init__(self, held: HeldTest, other: HeldTest, theme: Theme) -> None:
        super().__init__()
        places, (here, there) = common_shapes(held, other)
        said = QLabel(
            f"{held.run} beside {other.run}: {len(places)} common places of {len(held.shapes.places)} and "
            f"{len(other.shapes.places)}"
        )
        said.setWordWrap(True)
        self.table = ModeTable(HEADINGS, range(6))
        self.alike = MacChart(
            "test-mac",
            "how alike the shapes of both runs are: MAC",
            "mode there: f [Hz]",
            "mode here: f [Hz]",
            theme,
        )
        layout, row = QVBoxLayout(self), QHBoxLayout()
        layout.addWidget(said)
        layout.addLayout(row, stretch=1)
        row.addWidget(self.table, stretch=1)
        row.addWidget(self.alike, stretch=1)
        if len(places) < LEAST_COMMON or not len(here) or not len(there):
            self.alike.setTitle("no MAC: fewer than two places with modes are common to both")
            self.table.show_rows([])
            return
        self.value = mac(here, there)
        self.alike.show_mac(self.value, *(mode_names(one.modes, one.shapes) for one in (held, other)))
        self.table.show_rows([self._row(held, other, n) for n in range(len(here))])

    def _row(self, held: HeldTest, other: HeldTest, n: int) -> tuple[str, ...]:
        best = int(self.value[n].argmax())
        f, zeta = float(held.places[n]), 100.0 * float(held.reading.damping_ratio[held.shapes.pole[n]])
        alike = f"{self.value[n, best]:.3f}"
        if self.value[n, best] < LEAST_PAIRED_MAC:
            return f"{f:.3f}", "–", "–", f"{zeta:.3f}", "–", alike
        g, there = float(other.places[best]), 100.0 * float(other.reading.damping_ratio[other.shapes.pole[best]])
        return f"{f:.3f}", f"{g:.3f}", f"{100.0 * (g / f - 1.0):+.3f}", f"{zeta:.3f}", f"{there:.3f}", alike


def common_shapes(held: HeldTest, other: HeldTest) -> tuple[list[str], tuple[Complex, Complex]]:
    """Return places that both have, and the shapes (S, K) and (U, K) of both there, along the positive axes."""
    known = [_along(one) for one in (held, other)]
    places = sorted(known[0].keys() & known[1].keys())
    here, there = (np.array([row[place] for place in places], complex).reshape(len(places), -1).T for row in known)
    return places, (here, there)


def _along(one: HeldTest) -> dict[str, Complex]:
    return {
        along_axis(place): direction_sign(place) * one.shapes.shape[:, n]
        for n, place in enumerate(one.shapes.places)
    }
