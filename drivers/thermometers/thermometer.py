"""What every thermometer can do."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from drivers.ovens.error import OvenError


class ThermometerError(OvenError):
    """Trouble with the thermometer, of the same kinds as with an oven."""

    instrument = "thermometer"


class Thermometer(Protocol):
    """Sensors on the plate; each verb may raise `ThermometerError`."""

    def temperatures(self) -> NDArray[np.float64]:
        """Return all readings now, (T,), degrees Celsius; NaN for a sensor that says it is broken."""
        ...

    def close(self) -> None:
        """Let go of it; may be called twice."""
        ...
