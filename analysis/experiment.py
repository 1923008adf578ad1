"""The experiment as declared: plate, patches, electronics and protocol, each checked when read.

Every model refuses nonsense with the key, the value seen and the range allowed; the ranges are wide
enough for any plate of a laboratory and tight enough to catch a wrong unit (mm for m, g for kg, K
for degrees Celsius, kHz for Hz).
"""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from analysis.declared import Declared
from analysis.plate_material import PlateMaterial

Point = tuple[float, float]
Length = Annotated[float, Field(ge=0.01, le=5.0, description="m")]
Width = Annotated[float, Field(ge=0.001, le=1.0, description="m")]
Temperature = Annotated[float, Field(ge=-80.0, le=200.0, description="degrees Celsius")]


class Plate(Declared):
    """A rectangular plate of uniform thickness, a corner at the origin."""

    length_x: Length
    length_y: Length
    thickness: Annotated[float, Field(ge=1e-4, le=0.05, description="m")]
    mass: Annotated[float, Field(gt=0.0, le=200.0, description="kg, weighed bare")]
    boundary: Literal["free", "clamped"] = "free"
    material: Annotated[PlateMaterial | None, Field(exclude_if=lambda declared: declared is None)] = None

    @property
    def density(self) -> float:
        """Mass over volume, kg/m3."""
        return self.mass / (self.length_x * self.length_y * self.thickness)

    @model_validator(mode="after")
    def _plausible(self) -> Self:
        if not 20.0 <= self.density <= 25_000.0:
            raise ValueError(
                f"mass {self.mass:g} kg over the plate's volume gives a density of {self.density:.4g} kg/m3; "
                "allowed 20 to 25000 (lengths in m, mass in kg?)"
            )
        if self.thickness > min(self.length_x, self.length_y) / 5.0:
            raise ValueError(
                f"thickness {self.thickness:g} m is more than a fifth of the shorter side: not a plate"
            )
        return self


class Patch(Declared):
    """A rectangular piezo patch glued to one face, edges parallel to the plate's."""

    id: Annotated[str, Field(min_length=1, max_length=32)]
    role: Literal["actuator", "sensor"]
    center: Point
    size: tuple[Width, Width]
    thickness: Annotated[float, Field(ge=5e-5, le=5e-3, description="m")]
    side: Literal["top", "bottom"] = "top"
    material: Literal["NCE51", "PIC255", "PZT-5A", "PZT-5H"] = "NCE51"

    def span(self, axis: int) -> tuple[float, float]:
        """Lower and upper edge along x (0) or y (1), m."""
        half = self.size[axis] / 2.0
        return self.center[axis] - half, self.center[axis] + half

    def overlaps(self, other: "Patch") -> bool:
        """Whether both cover a common area of the same face."""
        return self.side == other.side and all(
            self.span(a)[0] < other.span(a)[1] - 1e-9 and other.span(a)[0] < self.span(a)[1] - 1e-9 for a in (0, 1)
        )


class Attachment(Declared):
    """A point where a string or a cable holds the plate."""

    point: Point


class Acquisition(Declared):
    """The input module and what it puts across each sensor patch."""

    module: str
    sample_rate: Annotated[float, Field(ge=100.0, le=2e6, description="Hz, as read back")]
    input_resistance: Annotated[float, Field(ge=1e3, le=1e12, description="ohm")]
    input_capacitance: Annotated[float, Field(ge=0.0, le=1e-6, description="F, module plus cable")]


class Protocol(Declared):
    """Which sweeps were made, at which temperatures."""

    sweep: Literal["logarithmic", "linear"]
    band: Annotated[tuple[float, float], Field(description="Hz")]
    sweep_duration: Annotated[float, Field(gt=0.0, le=3600.0, description="s")]
    tail: Annotated[float, Field(ge=0.0, le=600.0, description="s of silence")]
    repeats: Annotated[int, Field(ge=1, le=1000)]
    ramp_rate: Annotated[float, Field(ge=0.0, le=60.0, description="K/min, magnitude")]
    temperatures: Annotated[tuple[Temperature, ...], Field(min_length=1)]
    directions: Annotated[tuple[Literal["up", "down"], ...], Field(min_length=1, max_length=2)]
    levels: Annotated[tuple[Annotated[float, Field(gt=0.0, le=100.0)], ...], Field(min_length=1)]

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        low, high = self.band
        if not 0.0 < low < high:
            raise ValueError(f"band {list(self.band)} Hz: the lower edge must be above 0 and below the upper edge")
        for before, after in zip(self.temperatures, self.temperatures[1:], strict=False):
            if after <= before:
                raise ValueError(f"temperatures must ascend: {after:g} follows {before:g}")
        if len(set(self.directions)) != len(self.directions):
            raise ValueError(f"directions {list(self.directions)} name a leg twice")
        return self


class Oven(Declared):
    """The oven and the room it stands in."""

    room_temperature: Temperature


class Experiment(Declared):
    """All that is declared of a campaign: the ``campaign.toml`` of ``recorded-campaign/1``."""

    format: Literal["recorded-campaign/1"] = "recorded-campaign/1"
    title: str
    plate: Plate
    patch: Annotated[tuple[Patch, ...], Field(min_length=2)]
    string: tuple[Attachment, ...] = ()
    cable: tuple[Attachment, ...] = ()
    acquisition: Acquisition
    protocol: Protocol
    oven: Oven

    @property
    def actuator(self) -> Patch:
        """The one patch that is driven."""
        return next(p for p in self.patch if p.role == "actuator")

    @property
    def sensors(self) -> tuple[Patch, ...]:
        """The patches that are read, in the order declared."""
        return tuple(p for p in self.patch if p.role == "sensor")

    @model_validator(mode="after")
    def _on_the_plate(self) -> Self:
        actuators = [p.id for p in self.patch if p.role == "actuator"]
        if len(actuators) != 1:
            raise ValueError(f"patch: {len(actuators)} have the role actuator ({actuators}); exactly 1 allowed")
        check_patches(self.plate, self.patch)
        for kind in ("string", "cable"):
            for number, attachment in enumerate(getattr(self, kind)):
                x, y = attachment.point
                if not (0.0 <= x <= self.plate.length_x and 0.0 <= y <= self.plate.length_y):
                    raise ValueError(f"{kind}[{number}].point {[x, y]} m is off the plate")
        if self.protocol.band[1] >= self.acquisition.sample_rate / 2.0:
            raise ValueError(
                f"protocol.band ends at {self.protocol.band[1]:g} Hz, not below half of "
                f"acquisition.sample_rate ({self.acquisition.sample_rate:g} Hz)"
            )
        return self


def check_patches(plate: Plate, patches: tuple[Patch, ...]) -> None:
    """Raise ValueError unless every patch has its own name and place, inside the plate's outline."""
    names = [p.id for p in patches]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"patch id {name!r} is used {names.count(name)} times")
    for patch in patches:
        for axis, length in enumerate((plate.length_x, plate.length_y)):
            low, high = patch.span(axis)
            if low < 0.0 or high > length:
                raise ValueError(
                    f"patch {patch.id!r} spans {low:g} to {high:g} m along {'xy'[axis]}; "
                    f"the plate allows 0 to {length:g}"
                )
    for i, first in enumerate(patches):
        for second in patches[i + 1 :]:
            if first.overlaps(second):
                raise ValueError(f"patches {first.id!r} and {second.id!r} overlap on the {first.side} face")
