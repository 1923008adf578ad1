"""Part of the plate to be moved: rectangle, ellipse, polygon, or several, in fractions of the plate's lengths."""

from itertools import combinations
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from analysis.declared import Degrees, Sparse
from analysis.geometry import shapes
from analysis.geometry.loop import Loop
from analysis.geometry.relations import overlap, self_crossing

Fraction = Annotated[float, Field(gt=0.0, lt=1.0)]
Size = Annotated[float, Field(ge=1e-4, lt=1.0)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
Pair = tuple[float, float]
SMALLEST_AREA = 1e-8
"""Smallest area of a polygon, as a fraction of the area of the box around the plate."""


class Spot(Sparse):
    """One part to be moved: `shape` of `size` about `center`, turned by `angle`, or a `polygon`.

    In fractions of the plate's lengths: of the box around its outline.
    """

    center: tuple[Fraction, Fraction] | None = None
    size: tuple[Size, Size] | None = None
    shape: Literal["rectangle", "ellipse"] = "rectangle"
    angle: Degrees = 0.0
    polygon: tuple[tuple[Share, Share], ...] = ()

    def loop(self, corner: Pair, lengths: Pair) -> Loop:
        """Border, m, on a plate whose box has this lower left `corner` and these `lengths`, m."""
        if self.center is None or self.size is None:
            return shapes.polygon(
                [(corner[0] + x * lengths[0], corner[1] + y * lengths[1]) for x, y in self.polygon]
            )
        center = (corner[0] + self.center[0] * lengths[0], corner[1] + self.center[1] * lengths[1])
        size, angle = (self.size[0] * lengths[0], self.size[1] * lengths[1]), float(np.deg2rad(self.angle))
        if self.shape == "ellipse":
            return shapes.ellipse(center, (0.5 * size[0], 0.5 * size[1]), angle)
        return shapes.rectangle(center, size, angle)

    def _check(self, name: str) -> None:
        if self.polygon:
            if self.center is not None or self.size is not None:
                raise ValueError(f"{name} has a polygon and a center or size; keep one of them")
            if len(self.polygon) < 3:
                raise ValueError(
                    f"{name}: a polygon of {len(self.polygon)} points encloses nothing; give at least 3"
                )
            loop = self.loop((0.0, 0.0), (1.0, 1.0))
            place = self_crossing(loop)
            if place is not None:
                raise ValueError(f"{name}: the polygon crosses itself at {place[0]:g}, {place[1]:g} of the plate")
            if loop.area < SMALLEST_AREA:
                raise ValueError(
                    f"{name}: the polygon encloses {loop.area:.3g} of the area of the box around the plate; "
                    f"allowed from {SMALLEST_AREA:g}"
                )
            return
        if self.center is None or self.size is None:
            raise ValueError(f"{name} is empty; give center and size, or a polygon, or tables [[target.spot]]")
        if self.angle == 0.0:
            for axis, (center, size) in enumerate(zip(self.center, self.size, strict=True)):
                if center - size / 2.0 < 0.0 or center + size / 2.0 > 1.0:
                    raise ValueError(
                        f"{name} spans {center - size / 2:g} to {center + size / 2:g} of the plate along "
                        f"{'xy'[axis]}; allowed 0 to 1"
                    )


class Target(Spot):
    """Part of the plate to be moved: one, or several `spot` that move together, for example a stereo pair."""

    spot: tuple[Spot, ...] = ()
    displacement: Annotated[float, Field(ge=1e-12, le=1e-2, description="m per unit of audio signal")] = 1e-6

    @property
    def spots(self) -> tuple[Spot, ...]:
        """All parts."""
        return self.spot or (self,)

    @property
    def plain(self) -> bool:
        """Whether it is one rectangle along the plate's sides, whose share of a cell is known exactly."""
        return not self.spot and not self.polygon and self.shape == "rectangle" and self.angle == 0.0

    def loops(self, corner: Pair, lengths: Pair) -> tuple[Loop, ...]:
        """Borders of all parts, m."""
        return tuple(spot.loop(corner, lengths) for spot in self.spots)

    @model_validator(mode="after")
    def _each_somewhere(self) -> Self:
        if self.spot and (self.center is not None or self.size is not None or self.polygon):
            raise ValueError("target has tables [[target.spot]] and a shape of its own; keep one of them")
        for number, spot in enumerate(self.spots, start=1):
            spot._check(f"spot {number}" if self.spot else "target")
        pairs = combinations(enumerate(self.loops((0.0, 0.0), (1.0, 1.0)), start=1), 2)
        for (one, first), (other, second) in pairs:
            if overlap(first, second) is not None:
                raise ValueError(f"spots {one} and {other} overlap; move them apart")
        return self
