"""What drives and reads a plate that is acquired, each with the sensitivity by which its volts become units."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from analysis.channel import UNITS, Motion
from analysis.declared import Declared
from analysis.patch import Patch
from analysis.transducers import Drive, Sensor

RANGES: dict[Motion, tuple[float, float]] = {
    "acceleration": (1e-5, 2.0),
    "velocity": (1e-2, 1e6),
    "displacement": (1.0, 1e9),
}
"""Sensitivities that sensors have, V per SI unit."""


class Amplifier(Declared):
    """The power amplifier before the driven patch."""

    gain: Annotated[float, Field(gt=0.0, le=1000.0, description="V/V; roughly: it guards the patch")]


class Exciter(Declared):
    """The shaker, with its amplifier, that makes the generator's volts a force."""

    gain: Annotated[float, Field(gt=0.0, le=1000.0, description="N/V; roughly: it guards the exciter")]
    rated_force: Annotated[float, Field(gt=0.0, le=1e4, description="N, amplitude")]


class AcquiredPatch(Patch):
    """A patch; one that is read by its charge has the sensitivity of its charge amplifier."""

    sensitivity: Annotated[
        float | None, Field(ge=1e3, le=1e14, description="V/C, of the charge amplifier: 1 mV/pC is 1e9 V/C")
    ] = None

    @model_validator(mode="after")
    def _of_a_charge(self) -> Self:
        if self.quantity == "charge" and self.sensitivity is None:
            raise ValueError(
                f"patch {self.id!r} has quantity charge and no sensitivity; give that of its charge amplifier, "
                "1e3 to 1e14 V/C (1 mV/pC is 1e9 V/C)"
            )
        if self.quantity != "charge" and self.sensitivity is not None:
            raise ValueError(
                f"patch {self.id!r} has quantity {self.quantity} and sensitivity {self.sensitivity:g}; only a "
                "charge needs one: remove sensitivity"
            )
        return self

    @property
    def volts(self) -> float:
        """V per unit of what is read."""
        return 1.0 if self.sensitivity is None else self.sensitivity

    def recorded(self) -> Patch:
        """Return what a campaign declares of it."""
        return Patch.model_validate(self.model_dump(exclude={"sensitivity"}))


class AcquiredDrive(Drive):
    """A force, and the sensor that measures it."""

    sensitivity: Annotated[float, Field(ge=1e-6, le=1.0, description="V/N, of the force sensor")]

    def recorded(self) -> Drive:
        """Return what a campaign declares of it."""
        return Drive.model_validate(self.model_dump(exclude={"sensitivity"}))


class AcquiredSensor(Sensor):
    """A sensor of motion; of many points, all with the same sensitivity."""

    sensitivity: Annotated[
        float, Field(gt=0.0, le=1e9, description="V per m/s2, m/s or m; with sensitivity_unit mV/g")
    ]
    sensitivity_unit: Annotated[
        Literal["mV/g"] | None, Field(description="of an accelerometer's; left out: SI")
    ] = None

    @model_validator(mode="after")
    def _plausible(self) -> Self:
        if self.sensitivity_unit is not None and self.kind != "acceleration":
            raise ValueError(
                f"sensor {self.id!r} has sensitivity_unit {self.sensitivity_unit} and measures {self.kind}; "
                f"remove sensitivity_unit and give V per {UNITS[self.kind]}"
            )
        low, high = RANGES[self.kind]
        if not low <= self.volts <= high:
            unit = f"V per {UNITS[self.kind]}"
            seen = f"{self.sensitivity:g} {self.sensitivity_unit or unit}"
            other = '; sensitivity_unit = "mV/g" takes a data sheet\'s' if self.kind == "acceleration" else ""
            raise ValueError(
                f"sensor {self.id!r} has sensitivity {seen}; {low:g} to {high:g} {unit} allowed{other}"
            )
        return self

    @property
    def volts(self) -> float:
        """V per SI unit."""
        from scipy.constants import g

        return self.sensitivity if self.sensitivity_unit is None else self.sensitivity * 1e-3 / g

    def recorded(self) -> Sensor:
        """Return what a campaign declares of it."""
        return Sensor.model_validate(self.model_dump(exclude={"sensitivity", "sensitivity_unit"}))
