"""What every thermometer can do."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray


class Thermometer(Protocol):
    """Sensors on the plate; each verb may raise `OvenError`, whose fault says whether to ask again."""

    def temperatures(self) -> NDArray[np.float64]:
        """Return all readings now, (T,), degrees Celsius; NaN for a sensor that says it is broken."""
        ...

    def close(self) -> None:
        """Let go of it; may be called twice."""
        ...
