"""A thermometer of which only its values are known: where to ask for each."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drivers.ovens.error import OvenError
from drivers.ovens.line import Line
from drivers.ovens.points import Value
from drivers.thermometers.thermometer import ThermometerError


class PointThermometer:
    """Asks one value after the other.

    Parameters
    ----------
    line : Line
        The values are on it; closed where one of them cannot be read now.
    values : sequence of Value

    Raises
    ------
    OvenError
        If a value cannot be read.
    """

    def __init__(self, line: Line, values: Sequence[Value]) -> None:
        self._line = line
        self._values = tuple(values)
        try:
            self.temperatures()
        except BaseException:
            line.close()
            raise

    def temperatures(self) -> NDArray[np.float64]:
        """Return all readings, degrees Celsius."""
        try:
            with self._line.reserved():
                return np.array([value.read() for value in self._values])
        except OvenError as error:  # said of whatever is on the line
            raise ThermometerError(error.fault, error.what, error.advice, error.code) from error

    def close(self) -> None:
        """Let go of the line."""
        self._line.close()
