"""Kind ``scpi``: a thermometer whose queries stand in the experiment's file."""

from typing import Annotated

from pydantic import Field

from drivers.clock import Clock
from drivers.ovens.line import Transport
from drivers.ovens.phrases import TemperatureQuery
from drivers.ovens.simulated.controller import Controller
from drivers.ovens.simulated.regulated_oven import RegulatedOven
from drivers.ovens.simulated.scpi import SimulatedQueries
from drivers.ovens.text_protocol import TextLine, TextValue
from drivers.thermometers.points import PointThermometer
from drivers.thermometers.settings import ThermometerSettings
from drivers.thermometers.thermometer import Thermometer


class ScpiThermometer(TextLine, ThermometerSettings):
    """A meter with its queries, one for each sensor on the plate."""

    sensors: Annotated[
        tuple[TemperatureQuery, ...], Field(min_length=1, max_length=16, description="queries, one a sensor")
    ]

    def open(self, clock: Clock, transport: Transport | None = None) -> Thermometer:
        """Open the line, and send every query once."""
        connection = self.connection(clock, transport)
        values = [TextValue(f"sensors[{n}]", connection, sensor) for n, sensor in enumerate(self.sensors)]
        return PointThermometer(connection.line, values)

    def simulated(self, body: RegulatedOven, clock: Clock) -> Controller:
        """Return a meter on the plate that answers these queries."""
        return SimulatedQueries(self.terminator, self.sensors, lambda: body.plate)
