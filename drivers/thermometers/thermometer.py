"""What every thermometer can do, what every kind of ``[thermometer]`` declares, and where the kinds are found."""

from typing import Annotated, Protocol

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from analysis.declaration.strict import Declared
from drivers.clock import Clock
from drivers.kinds import Kinds
from drivers.ovens.error import OvenError
from drivers.ovens.line import Transport
from drivers.ovens.simulated.controller import Controller
from drivers.ovens.simulated.regulated_oven import RegulatedOven


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


class ThermometerSettings(Declared):
    """A thermometer on the plate. Each kind derives from it, adds how it is reached, and opens it."""

    kind: Annotated[str, Field(description="protocol")]

    @property
    def place(self) -> str:
        """Where it is reached, for messages."""
        return ""

    def open(self, clock: Clock, transport: Transport | None = None) -> Thermometer:
        """Return the thermometer after a first exchange with it; see `OvenSettings.open`."""
        raise NotImplementedError

    def simulated(self, body: RegulatedOven, clock: Clock) -> Controller | None:
        """Return an instrument that answers the driver, on the plate of `body`; None where there is none."""
        return None


THERMOMETERS = Kinds(
    "flexura.thermometers",
    ThermometerSettings,
    {
        "modbus-map": "drivers.thermometers.declared_thermometer:ModbusMapThermometer",
        "scpi": "drivers.thermometers.declared_thermometer:ScpiThermometer",
    },
)
