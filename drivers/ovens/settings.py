"""The ``[oven]`` of a rig file: what every kind declares, and where the kinds are found."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Self

from pydantic import Field, model_validator

from analysis.declaration.strict import Declared, Temperature
from drivers.clock import Clock, SystemClock
from drivers.kinds import Kinds
from drivers.ovens.line import Transport
from drivers.ovens.oven import Oven, OvenLimits

if TYPE_CHECKING:  # simulated ovens need numpy, which the watchdog's process does without
    from drivers.ovens.simulated.controller import Controller
    from drivers.ovens.simulated.regulated_oven import RegulatedOven


class OvenSettings(Declared):
    """What an oven may be asked for. Each kind derives from it, adds how it is reached, and opens it."""

    kind: Annotated[str, Field(description="maker and protocol of the controller")]
    minimum: Annotated[Temperature, Field(description="degrees Celsius, lowest set-point sent")]
    maximum: Annotated[Temperature, Field(description="degrees Celsius, highest set-point sent")]
    max_rate: Annotated[float, Field(gt=0.0, le=60.0, description="K/min, steepest ramp sent")]

    @model_validator(mode="after")
    def _bounded(self) -> Self:
        self.limits()
        return self

    @property
    def place(self) -> str:
        """Where it is reached, for messages: a port, a host; empty where there is no such thing."""
        return ""

    @property
    def expires(self) -> bool:
        """Whether the oven comes to rest by itself if the program ends or loses it."""
        return False

    def rest_temperature(self, room: float) -> float:
        """Return where the oven goes when it is brought to rest, °C: to `room`, unless a set-point is kept."""
        return room

    def limits(self) -> OvenLimits:
        """Return what set-points are clamped to."""
        return OvenLimits(self.minimum, self.maximum, self.max_rate)

    def open(self, clock: Clock, transport: Transport | None = None) -> Oven:
        """Return the oven after a first exchange with it; of all a kind does, only this is obligatory.

        Parameters
        ----------
        transport : Transport, optional
            Instead of the port declared: a simulated controller in memory, say. A kind without a line has no use
            for it.

        Raises
        ------
        OvenError
            If it cannot be reached or does not answer as its kind should; nothing is left open then.
        """
        raise NotImplementedError

    def simulated(self, body: "RegulatedOven", clock: Clock) -> "Controller | None":
        """Return a controller that answers the kind's driver around `body`; None where the kind has none."""
        return None


OVENS = Kinds(
    "flexura.ovens",
    OvenSettings,
    {
        "eurotherm-2400": "drivers.ovens.controllers:EurothermSettings",
        "eurotherm-3500": "drivers.ovens.controllers:EurothermSettings",
        "votsch-ascii2": "drivers.ovens.controllers:VotschSettings",
        "espec-p300": "drivers.ovens.controllers:EspecSettings",
        "watlow-f4t": "drivers.ovens.controllers:WatlowSettings",
        "modbus-map": "drivers.ovens.declared_oven:ModbusMapOven",
        "scpi": "drivers.ovens.declared_oven:ScpiOven",
    },
)


def oven_settings(declared: Mapping[str, Any]) -> OvenSettings:
    """Return the settings in a table, as its ``kind`` understands them.

    Raises
    ------
    KindError
        For a kind that is not there.
    pydantic.ValidationError
        For any other key.
    """
    return OVENS.find(str(declared.get("kind"))).model_validate(declared)


def open_oven(settings: OvenSettings, clock: Clock | None = None, transport: Transport | None = None) -> Oven:
    """Return the oven that `settings` describe, after a first exchange with it; see `OvenSettings.open`.

    Parameters
    ----------
    clock : Clock, optional
        The machine's own by default.
    transport : Transport, optional
        Instead of the port declared.
    """
    return settings.open(clock or SystemClock(), transport)
