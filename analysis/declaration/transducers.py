"""Drives and sensors as declared: hammers, shakers, accelerometers, laser vibrometers; and piezo patches.

A motion is positive out of the face it is taken on, a force where it pushes that face, as force cells have it.
Patches are rectangular, turned or round, on either face.
"""

from functools import cached_property
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, ValidationInfo, field_validator, model_validator

from analysis.channel import Channel, Footprint, Motion
from analysis.declaration.outline import check_disc
from analysis.declaration.strict import Degrees, Point, Sparse, Width
from analysis.geometry.loop import GeometryError, Loop, circle, rectangle
from analysis.geometry.relations import overlap

if TYPE_CHECKING:
    from analysis.declaration.plate import Plate

MOST_POINTS = 5000
"""Points of one instrument: a laser's, or those at which a hammer hits, each with a force of its own."""
Name = Annotated[str, Field(min_length=1, max_length=32)]
Radius = Annotated[float, Field(ge=0.0, le=0.05, description="m")]
Mass = Annotated[float, Field(ge=0.0, le=1.0, description="kg")]
Side = Literal["top", "bottom"]

BASE_RADIUS = 0.004
"""Radius of an accelerometer's base unless declared, m; a laser's spot counts as a point."""


class Drive(Sparse):
    """A force normal to the plate: an impact hammer, or a shaker through a force sensor.

    `radius` is that of the tip or stinger, `mass` what moves with the plate beyond the force sensor. Where a
    hammer moved, an `accelerometer` stays there, which drives by reciprocity.
    """

    always: ClassVar[frozenset[str]] = frozenset({"kind"})

    id: Name
    kind: Literal["force"] = "force"
    point: Point
    radius: Radius = 0.002
    side: Side = "top"
    mass: Mass = 0.0
    accelerometer: bool = False

    @property
    def contact_radius(self) -> float:
        """Of the disc on which it acts, m."""
        return self.radius

    @property
    def footprint(self) -> Footprint:
        """Where it acts."""
        return Footprint(self.point, self.radius, -1.0 if self.side == "top" else 1.0, self.mass)

    @property
    def channel(self) -> Channel:
        """The input that it is."""
        return Channel(self.id, "force", footprint=self.footprint)

    def check(self, plate: "Plate") -> None:
        """Raise GeometryError unless it lies on the plate."""
        check_disc(f"drive {self.id!r}", self.point, self.radius, plate.loop, plate.hole_loops)


class Sensor(Sparse):
    """A motion normal to the plate, at a point, at several, or on a grid.

    `grid` counts points along x and y over the plate's bounding box, `margin` from its sides; those off the plate
    are left out. `mass` is an accelerometer's own: it loads the plate.
    """

    id: Name
    kind: Motion
    point: Point | None = None
    points: Annotated[tuple[Point, ...] | None, Field(min_length=1, max_length=MOST_POINTS)] = None
    grid: tuple[Annotated[int, Field(ge=1, le=200)], Annotated[int, Field(ge=1, le=200)]] | None = None
    margin: Annotated[float, Field(ge=0.0, le=1.0, description="m")] = 0.005
    radius: Radius | None = None
    side: Side = "top"
    mass: Mass = 0.0

    @model_validator(mode="after")
    def _one_place(self) -> Self:
        given = [name for name in ("point", "points", "grid") if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(
                f"sensor {self.id!r} has {' and '.join(given) or 'no place'}; give one of point, points, grid"
            )
        if self.id == "drive":
            raise ValueError("sensor 'drive' has the name of the drive's channel; choose another id")
        if self.mass and self.kind != "acceleration":
            raise ValueError(
                f"sensor {self.id!r}: mass {self.mass:g} kg on a sensor of {self.kind}; only accelerometers "
                "load the plate: remove mass"
            )
        return self

    @property
    def contact_radius(self) -> float:
        """Of the disc over which it averages, m: as declared, else that of a usual base, or a laser's point."""
        usual = BASE_RADIUS if self.kind == "acceleration" else 0.0
        return usual if self.radius is None else self.radius

    def places(self, plate: "Plate") -> tuple[Point, ...]:
        """Where it measures, m; of a grid, x slowest."""
        if self.point is not None:
            return (self.point,)
        if self.points is not None:
            return self.points
        if self.grid is None:
            raise AssertionError("refused when it was made")
        axes = [
            np.linspace(low + self.margin, high - self.margin, count)
            if count > 1
            else np.array([(low + high) / 2])
            for low, high, count in zip(*plate.bounds, self.grid, strict=True)
        ]
        points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
        return tuple((float(x), float(y)) for x, y in points[plate.contains(points)])

    def channels(self, plate: "Plate") -> tuple[Channel, ...]:
        """Return its outputs; those of many points are numbered from 1."""
        radius = self.contact_radius
        along = 1.0 if self.side == "top" else -1.0
        return tuple(
            Channel(
                self.id if self.point is not None else f"{self.id}{number}",
                self.kind,
                footprint=Footprint(place, radius, along, self.mass),
            )
            for number, place in enumerate(self.places(plate), start=1)
        )

    def check(self, plate: "Plate") -> None:
        """Raise GeometryError unless all of it lies on the plate."""
        self._check_margin(plate)
        channels = self.channels(plate)
        if not channels:
            raise GeometryError(f"sensor {self.id!r}: no point of its grid is on the plate; lessen margin")
        for footprint in (channel.footprint for channel in channels):
            if footprint is not None:
                check_disc(f"sensor {self.id!r}", footprint.point, footprint.radius, plate.loop, plate.hole_loops)

    def _check_margin(self, plate: "Plate") -> None:
        """Refuse a margin of half a side or more, which would turn the grid inside out."""
        for axis, count, low, high in zip("xy", self.grid or (), *plate.bounds, strict=False):
            most = 0.5 * (high - low)
            if count > 1 and self.margin >= most:
                raise GeometryError(
                    f"sensor {self.id!r}: margin {self.margin:g} m; allowed 0 to less than {most:.3g} m, half of "
                    f"the plate's {2 * most:.3g} m along {axis}: lessen margin"
                )


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
            return circle(self.center, 0.5 * self.diameter)
        return rectangle(self.center, self.size, float(np.deg2rad(self.angle)))

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
