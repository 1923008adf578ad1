"""Dark and light: colours that can be distinguished with any colour vision.

Lines take the palette of Okabe and Ito, maps viridis (one-sided) and CET-CBD1 (two-sided, made for two-colour
vision); all are perceptually uniform or tested for it.
"""

from dataclasses import dataclass

import numpy as np
import pyqtgraph
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QGuiApplication, QPalette
from PySide6.QtWidgets import QApplication

Color = str | tuple[int, int, int] | tuple[int, int, int, int]


@dataclass(frozen=True)
class Theme:
    """Colours of one theme.

    Attributes
    ----------
    name : str
    window, plot, text, muted : str
        Behind everything, behind curves, of words, of axes and what matters less.
    measured, identified, twin, corrected, warning : str
        What a curve stands for.
    temperature_span : (float, float)
        Part of the map plasma that can be distinguished from the background.
    """

    name: str
    window: str
    plot: str
    text: str
    muted: str
    measured: str
    identified: str
    twin: str
    corrected: str
    warning: str
    temperature_span: tuple[float, float]

    def temperature(self, share: float) -> Color:
        """Colour between the coldest (0) and the hottest (1)."""
        low, high = self.temperature_span
        return tuple(int(c) for c in one_sided("plasma").map(low + (high - low) * share)[:3])  # type: ignore[return-value]

    def series(self, number: int) -> Color:
        """Colour of one of several things that stand in no order."""
        return (self.identified, self.twin, self.corrected, self.warning, "#b07aa1", self.muted)[number % 6]


LIGHT = Theme(
    name="light",
    window="#eef0f3",
    plot="#ffffff",
    text="#1c2127",
    muted="#77818c",
    measured="#1c2127",
    identified="#0072b2",
    twin="#d55e00",
    corrected="#009e73",
    warning="#c2185b",
    temperature_span=(0.0, 0.82),
)
DARK = Theme(
    name="dark",
    window="#1b1f25",
    plot="#12151a",
    text="#e4e8ed",
    muted="#8a94a0",
    measured="#f2f4f7",
    identified="#56b4e9",
    twin="#f0883e",
    corrected="#2cc9a0",
    warning="#ff6f91",
    temperature_span=(0.22, 1.0),
)
THEMES = {theme.name: theme for theme in (LIGHT, DARK)}


def system_theme() -> Theme:
    """Return the theme that the desktop asks for."""
    dark = QGuiApplication.styleHints().colorScheme() == Qt.ColorScheme.Dark
    return DARK if dark else LIGHT


def one_sided(name: str = "viridis") -> pyqtgraph.ColorMap:
    """Map for amounts."""
    return pyqtgraph.colormap.get(name)


def two_sided() -> pyqtgraph.ColorMap:
    """Map for what has a sign."""
    return pyqtgraph.colormap.get("CET-CBD1")


def beyond_noise(theme: Theme) -> pyqtgraph.ColorMap:
    """Map of residuals: the background's colour where there is noise only."""
    steps = np.linspace(0.0, 1.0, 24)
    inside = 1.0 - steps if theme is LIGHT else steps
    colors = one_sided("magma").map(0.06 + 0.86 * inside)
    colors[0] = QColor(theme.plot).getRgb()
    return pyqtgraph.ColorMap(steps, colors)


def apply(theme: Theme) -> None:
    """Give the application's widgets the colours of a theme."""
    app = QApplication.instance()
    if not isinstance(app, QApplication):
        raise RuntimeError("no application runs that could take a theme")
    palette, role = QPalette(), QPalette.ColorRole
    for roles, color in (
        ((role.Window, role.Button), theme.window),
        ((role.Base, role.ToolTipBase), theme.plot),
        ((role.AlternateBase,), theme.window),
        ((role.WindowText, role.Text, role.ButtonText, role.ToolTipText, role.BrightText), theme.text),
        ((role.PlaceholderText,), theme.muted),
        ((role.Highlight, role.Link, role.Accent), theme.identified),
        ((role.HighlightedText,), theme.plot),
    ):
        for one in roles:
            palette.setColor(one, QColor(color))
    for one in (role.Text, role.ButtonText, role.WindowText):
        palette.setColor(QPalette.ColorGroup.Disabled, one, QColor(theme.muted))
    app.setPalette(palette)
    # Fusion draws the frame of an empty box darker than the window, which is invisible on a dark one
    box = f"border: 1px solid {theme.muted}; border-radius: 2px; width: 11px; height: 11px; margin: 1px"
    app.setStyleSheet(f"QCheckBox::indicator:unchecked, QListView::indicator:unchecked {{ {box} }}")
