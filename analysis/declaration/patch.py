"""Piezo patches as declared: rectangular, turned or round, on either face."""

from functools import cached_property
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, ValidationInfo, field_validator, model_validator

from analysis.declaration.strict import Degrees, Point, Sparse, Width
from analysis.geometry import shapes
from analysis.geometry.loop import Loop
from analysis.geometry.relations import overlap

UNSET = float("nan")

RATED_FIELD = {"NCE51": 5e5, "PIC255": 5e5, "PZT-5A": 5e5, "PZT-5H": 3e5}
"""Field strength, V/m, either way, that soft ceramics bear for long without losing their poling: half of the
coercive field and less. For a patch with a better known limit, declare `rated_field`."""


class Patch(Sparse):
    """A piezo patch glued to one face: of `size`, its first side turned by `angle`, or round, of `diameter`.

    A round patch has the `size` of the square around it. A sensor is read by its voltage, or by its charge: then
    an amplifier holds the patch at 0 V. Patches that are neither driven nor read are ``shorted`` or ``open``.
    """

    always: ClassVar[frozenset[str]] = frozenset({"side", "material"})

    id: Annotated[str, Field(min_length=1, max_length=32)]
    role: Literal["actuator", "sensor", "shorted", "open"]
    quantity: Literal["voltage", "charge"] = "voltage"
    center: Point
    size: tuple[Width, Width] = (UNSET, UNSET)
    diameter: Annotated[float | None, Field(ge=0.001, le=1.0, description="m", validate_default=True)] = None
    angle: Degrees = 0.0
    thickness: Annotated[float, Field(ge=5e-5, le=5e-3, description="m")]
    side: Literal["top", "bottom"] = "top"
    material: Literal["NCE51", "PIC255", "PZT-5A", "PZT-5H"] = "NCE51"
    rated_field: Annotated[
        float | None, Field(ge=1e3, le=1e7, description="V/m, peak, either way; left out, the material's")
    ] = None

    @property
    def rated_voltage(self) -> float:
        """Peak voltage it may be driven with, V."""
        return (self.rated_field or RATED_FIELD[self.material]) * self.thickness

    @cached_property
    def loop(self) -> Loop:
        """Its border."""
        if self.diameter is not None:
            return shapes.circle(self.center, 0.5 * self.diameter)
        return shapes.rectangle(self.center, self.size, float(np.deg2rad(self.angle)))

    @property
    def area(self) -> float:
        """Area covered, m2."""
        return self.loop.area

    def span(self, axis: int) -> tuple[float, float]:
        """Lowest and highest place along x (0) or y (1), m."""
        if self.diameter is not None or self.angle == 0.0:
            half = self.size[axis] / 2.0
            return self.center[axis] - half, self.center[axis] + half
        low, high = self.loop.bounds
        return float(low[axis]), float(high[axis])

    def overlaps(self, other: "Patch") -> bool:
        """Whether both cover a common area of the same face."""
        return self.side == other.side and overlap(self.loop, other.loop) is not None

    @field_validator("diameter")
    @classmethod
    def _has_an_extent(cls, value: float | None, others: ValidationInfo) -> float | None:
        """Of a field and not of the whole patch, to be told together with other keys that are missing."""
        if value is None and np.isnan(others.data.get("size", (0.0,))[0]):
            named = others.data.get("id", "")
            raise ValueError(f"patch {named!r} has no extent; give size = [along, across] or diameter, in m")
        return value

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        if self.diameter is None:
            return self
        if "size" in self.model_fields_set and set(self.size) != {self.diameter}:
            raise ValueError(f"patch {self.id!r} has a size and a diameter; keep one of them")
        if self.angle != 0.0:
            raise ValueError(f"patch {self.id!r} is round; remove angle")
        self.__dict__["size"] = (self.diameter, self.diameter)
        return self

    @model_validator(mode="after")
    def _charge_is_read(self) -> Self:
        if self.quantity == "charge" and self.role != "sensor":
            raise ValueError(
                f"patch {self.id!r} has quantity charge and the role {self.role}; only sensors are read"
            )
        return self

    def _left_out(self) -> set[str]:
        """Leave out the size that the diameter gives."""
        return super()._left_out() | (set() if self.diameter is None else {"size"})
