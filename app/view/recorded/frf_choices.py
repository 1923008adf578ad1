"""What the page of the FRFs is asked to show."""

from collections.abc import Mapping, Sequence

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QCheckBox, QComboBox, QGridLayout, QHBoxLayout, QLabel, QVBoxLayout, QWidget

from app.view.parts import PartsChoice


class FrfChoices(QWidget):
    """Sensor, run of sweeps, parts of the FRF, and switches of what is laid over.

    Parameters
    ----------
    channels, runs : sequence of str
    overlays : mapping of str to (str, str)
        Names of what may be laid over, with style and colour of its line.
    off : sequence of str
        Those that are not laid over at first.

    Attributes
    ----------
    changed : Signal()
        Something else was chosen.
    channel, sweeps : QComboBox
    display : PartsChoice
    overlays : dict of str to QCheckBox
    """

    changed = Signal()

    def __init__(
        self,
        channels: Sequence[str],
        runs: Sequence[str],
        overlays: Mapping[str, tuple[str, str]],
        off: Sequence[str],
    ) -> None:
        super().__init__()
        self.channel, self.sweeps, self.display = _choice(channels), _choice(runs), PartsChoice()
        self.overlays = {name: _switch(name, *line) for name, line in overlays.items()}
        chooser, whole = QHBoxLayout(), QVBoxLayout(self)
        for word, choice in (("sensor", self.channel), ("sweeps", self.sweeps)):
            chooser.addWidget(QLabel(word))
            chooser.addWidget(choice)
        self.display.setMinimumWidth(80)
        chooser.addWidget(self.display, stretch=1)
        self._grid = QGridLayout()
        whole.setContentsMargins(0, 0, 0, 0)
        whole.addLayout(chooser)
        whole.addLayout(self._grid)
        for name, switch in self.overlays.items():
            switch.setChecked(name not in off)
            self.add(switch)
        for box in (self.channel, self.sweeps, self.display):
            box.currentIndexChanged.connect(lambda _: self.changed.emit())

    def add(self, switch: QCheckBox) -> None:
        """Put a switch beside the others, two in a row."""
        self._grid.addWidget(switch, *divmod(self._grid.count(), 2))
        switch.toggled.connect(lambda _: self.changed.emit())

    def on(self, name: str) -> bool:
        """Whether something is to be laid over."""
        return self.overlays[name].isChecked()


def _choice(names: Sequence[str]) -> QComboBox:
    box = QComboBox()
    box.addItems(list(names))
    box.setEnabled(len(names) > 1)
    return box


def _switch(name: str, line: str, color: str) -> QCheckBox:
    switch = QCheckBox(name)
    switch.setStyleSheet(f"QCheckBox {{ border-left: 4px {line} {color}; padding-left: 6px; }}")
    return switch
