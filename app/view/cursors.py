"""The frequency and the temperature that all plots share."""

from PySide6.QtCore import QObject, Signal

FREQUENCY, TEMPERATURE = "frequency [Hz]", "temperature [°C]"
"""Labels of their axes."""


class Cursors(QObject):
    """One place in frequency and temperature.

    Attributes
    ----------
    frequency_moved, temperature_moved : Signal(float)
        Hz and degrees Celsius; sent only where the value has changed.
    """

    frequency_moved = Signal(float)
    temperature_moved = Signal(float)

    def __init__(self, frequency: float, temperature: float) -> None:
        super().__init__()
        self._frequency = frequency
        self._temperature = temperature

    @property
    def frequency(self) -> float:
        """Hz."""
        return self._frequency

    @frequency.setter
    def frequency(self, value: float) -> None:
        if value != self._frequency:
            self._frequency = value
            self.frequency_moved.emit(value)

    @property
    def temperature(self) -> float:
        """Degrees Celsius."""
        return self._temperature

    @temperature.setter
    def temperature(self, value: float) -> None:
        if value != self._temperature:
            self._temperature = value
            self.temperature_moved.emit(value)
