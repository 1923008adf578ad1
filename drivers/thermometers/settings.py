"""The ``[thermometer]`` of a rig file: what every kind declares, and where the kinds are found."""

from typing import Annotated

from pydantic import Field

from analysis.declaration.strict import Declared
from drivers.clock import Clock
from drivers.kinds import Kinds
from drivers.ovens.line import Transport
from drivers.ovens.simulated.controller import Controller
from drivers.ovens.simulated.regulated_oven import RegulatedOven
from drivers.thermometers.thermometer import Thermometer


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
