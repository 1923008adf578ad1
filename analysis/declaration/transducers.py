"""Drives and sensors that are no patches: hammers, shakers, accelerometers, laser vibrometers.

A motion is positive out of the face it is taken on, a force where it pushes that face, as force cells have it.
"""

from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from analysis.channel import Channel, Footprint, Motion
from analysis.declaration.outline import check_disc
from analysis.declaration.plate import Plate
from analysis.declaration.strict import Point, Sparse
from analysis.geometry.fault import GeometryError

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

    `radius` is that of the tip or stinger, `mass` what moves with the plate beyond the force sensor.
    """

    always: ClassVar[frozenset[str]] = frozenset({"kind"})

    id: Name
    kind: Literal["force"] = "force"
    point: Point
    radius: Radius = 0.002
    side: Side = "top"
    mass: Mass = 0.0

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

    def check(self, plate: Plate) -> None:
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

    def places(self, plate: Plate) -> tuple[Point, ...]:
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

    def channels(self, plate: Plate) -> tuple[Channel, ...]:
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

    def check(self, plate: Plate) -> None:
        """Raise GeometryError unless all of it lies on the plate."""
        self._check_margin(plate)
        channels = self.channels(plate)
        if not channels:
            raise GeometryError(f"sensor {self.id!r}: no point of its grid is on the plate; lessen margin")
        for footprint in (channel.footprint for channel in channels):
            if footprint is not None:
                check_disc(f"sensor {self.id!r}", footprint.point, footprint.radius, plate.loop, plate.hole_loops)

    def _check_margin(self, plate: Plate) -> None:
        """Refuse a margin of half a side or more, which would turn the grid inside out."""
        for axis, count, low, high in zip("xy", self.grid or (), *plate.bounds, strict=False):
            most = 0.5 * (high - low)
            if count > 1 and self.margin >= most:
                raise GeometryError(
                    f"sensor {self.id!r}: margin {self.margin:g} m; allowed 0 to less than {most:.3g} m, half of "
                    f"the plate's {2 * most:.3g} m along {axis}: lessen margin"
                )
