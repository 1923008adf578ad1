"""A plate as declared: outline, holes, thickness zones, supports, shallow curvature, and a mesh made elsewhere."""

from dataclasses import replace
from typing import Annotated, ClassVar, Literal, Self, TypeVar

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import NDArray
from pydantic import Field, ValidationInfo, field_validator, model_validator

from analysis.arrays import Real
from analysis.declaration.outline import (
    AnyOutline,
    AnyZone,
    Piece,
    RectangleOutline,
    Support,
    SupportedEdge,
    check_parts,
    check_supports,
    supported_edges,
)
from analysis.declaration.plate_material import PlateMaterial, density_range
from analysis.declaration.strict import TEMPERATURES, Declared, Length, Point, Sparse, Temperature, Thickness
from analysis.geometry.loop import GeometryError, Loop, at, circle, rectangle
from analysis.geometry.relations import TOUCH, just_inside
from analysis.material import LocalLaws, MaterialBox, MaterialLaws

MOST_POINTS = 5000
"""Points of a mesh: functions of high degree need a few hundred."""
Number = Annotated[int, Field(ge=0, lt=MOST_POINTS)]
Cell = Annotated[int, Field(ge=0, lt=2 * MOST_POINTS)]


class ForeignMesh(Declared):
    """Triangles and quadrilaterals over a plate, straight or quadratic.

    A file (``file = "plate.msh"``) is turned into this when the declaration is read, so that a declaration holds
    the mesh itself and no path.

    Attributes
    ----------
    points
        x and y, m; points in the middle of quadratic edges among them.
    quads, triangles
        Corners of every cell.
    midsides
        Both ends of a quadratic edge, and the point in its middle.
    surface
        Cells, quadrilaterals counted first, of every physical surface by its name.
    curve
        Both ends of every edge on a physical curve, by its name.
    """

    points: Annotated[tuple[Point, ...], Field(min_length=3, max_length=MOST_POINTS)]
    quads: Annotated[tuple[tuple[Number, Number, Number, Number], ...], Field(max_length=MOST_POINTS)] = ()
    triangles: Annotated[tuple[tuple[Number, Number, Number], ...], Field(max_length=2 * MOST_POINTS)] = ()
    midsides: Annotated[tuple[tuple[Number, Number, Number], ...], Field(max_length=3 * MOST_POINTS)] = ()
    surface: Annotated[dict[str, tuple[Cell, ...]], Field(default_factory=dict, max_length=1000)]
    curve: Annotated[dict[str, tuple[tuple[Number, Number], ...]], Field(default_factory=dict, max_length=1000)]


UNSET = float("nan")
Laws = TypeVar("Laws", LocalLaws, MaterialLaws)
Bend = Annotated[float, Field(ge=-1e4, le=1e4, description="m, positive: centre of curvature above the plate")]
Heights = Annotated[tuple[float, ...], Field(min_length=1, max_length=9)]
STEEPEST_SLOPE = 0.3
"""Largest slope of a shallow shell."""
FLAT_RISE = 0.01
"""Rise of a plate, in thicknesses, below which a radius changes no frequency: by less than 1e-4."""


class Curvature(Sparse):
    """Height z(x, y) of the mid-plane.

    Either from one radius (a sphere, z = (x² + y²) / 2R) or two (along x and along y; only one: a cylinder), about
    the middle of the plate's bounding box; or from `height`, coefficients c in m of z = sum of c[i][j] xi^i zeta^j
    with xi and zeta from -1 to 1 over the bounding box along x and y.
    """

    radius: Bend | None = None
    radius_x: Bend | None = None
    radius_y: Bend | None = None
    height: Annotated[tuple[Heights, ...], Field(min_length=1, max_length=9, description="m")] | None = None

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        ways = [
            self.radius is not None,
            self.radius_x is not None or self.radius_y is not None,
            self.height is not None,
        ]
        if sum(ways) != 1:
            raise ValueError("give radius, or radius_x and radius_y (or one of them), or height: one of the three")
        for name in ("radius", "radius_x", "radius_y"):
            if getattr(self, name) == 0.0:
                raise ValueError(f"{name} is 0 m; leave it out for no curvature")
        return self

    def check_bent(self, half: tuple[float, float], thickness: float) -> None:
        """Refuse radii so large that the plate is flat, as of a radius in mm.

        Parameters
        ----------
        half : (float, float)
            Half lengths of the bounding box, m.
        thickness : float
            m.

        Raises
        ------
        ValueError
            With the radius, and how far the plate rises.
        """
        given = [name for name in ("radius", "radius_x", "radius_y") if getattr(self, name) is not None]
        rise = float(np.abs(self.coefficients(half)).sum())
        if given and rise < FLAT_RISE * thickness:
            raise ValueError(
                f"curvature.{given[0]} {getattr(self, given[0]):g} m: over this plate it rises by "
                f"{1e3 * rise:.2g} mm, which changes nothing; remove it (radius in m?)"
            )

    def coefficients(self, half: tuple[float, float]) -> Real:
        """Coefficients c[i, j] of xi^i zeta^j, m, on a bounding box of half lengths `half`, m."""
        if self.height is not None:
            table = np.zeros((len(self.height), max(len(row) for row in self.height)))
            for i, row in enumerate(self.height):
                table[i, : len(row)] = row
            return table
        table = np.zeros((3, 3))
        if self.radius is not None:
            along_x = along_y = 1.0 / self.radius
        else:
            along_x = 1.0 / self.radius_x if self.radius_x else 0.0
            along_y = 1.0 / self.radius_y if self.radius_y else 0.0
        table[2, 0], table[0, 2] = 0.5 * along_x * half[0] ** 2, 0.5 * along_y * half[1] ** 2
        return table

    def height_at(self, xi: Real, zeta: Real, half: tuple[float, float]) -> Real:
        """Heights of the mid-plane.

        Parameters
        ----------
        xi, zeta : (K,) ndarray
            Places, -1 to 1 over the bounding box.
        half : (float, float)
            Half lengths of the bounding box, m.

        Returns
        -------
        (K,) ndarray
            m.
        """
        return np.asarray(polynomial.polyval2d(xi, zeta, self.coefficients(half)))

    def slope_at(self, xi: Real, zeta: Real, half: tuple[float, float]) -> Real:
        """Slopes of the mid-plane along x and y.

        Parameters
        ----------
        xi, zeta : (K,) ndarray
            Places, -1 to 1 over the bounding box.
        half : (float, float)
            Half lengths of the bounding box, m.

        Returns
        -------
        (K, 2) ndarray
            m/m.
        """
        table = self.coefficients(half)
        slopes = [
            polynomial.polyval2d(xi, zeta, polynomial.polyder(table, axis=axis)) / half[axis] for axis in (0, 1)
        ]
        return np.stack(slopes, axis=-1)

    def bend_at(self, xi: Real, zeta: Real, half: tuple[float, float]) -> Real:
        """Second derivatives of the height of the mid-plane.

        Parameters
        ----------
        xi, zeta : (K,) ndarray
            Places, -1 to 1 over the bounding box.
        half : (float, float)
            Half lengths of the bounding box, m.

        Returns
        -------
        (2, 2, K) ndarray
            1/m.
        """
        first = [polynomial.polyder(self.coefficients(half), axis=a) / half[a] for a in (0, 1)]
        second = [[polynomial.polyder(one, axis=b) / half[b] for b in (0, 1)] for one in first]
        return np.array([[polynomial.polyval2d(xi, zeta, one) for one in row] for row in second])


class Plate(Sparse):
    """A plate of any outline: `length_x` times `length_y` with a corner at the origin, or given by `outline`.

    Attributes
    ----------
    length_x, length_y : float
        Extent of the bounding box, m; declared for a rectangle, found for every other outline.
    outline, hole, zone
        Closed outlines; zones have a thickness of their own.
    thickness, mass : float
        m; kg, weighed bare.
    boundary : {"free", "clamped"}
        Of all of the outline; `support` gives details.
    dimensions_at : float, optional
        Temperature of the surroundings at which the dimensions hold, degrees Celsius.
    expansion : float
        Coefficient of thermal expansion, 1/K.
    mesh : ForeignMesh, optional
        Made elsewhere; the plate is meshed here unless given.
    material : PlateMaterial, optional
        Of which elastic constants the twin has to know.
    """

    always: ClassVar[frozenset[str]] = frozenset({"length_x", "length_y", "thickness", "mass", "boundary"})

    length_x: Length = UNSET
    length_y: Length = UNSET
    outline: Annotated[AnyOutline | None, Field(validate_default=True)] = None
    hole: Annotated[tuple[AnyOutline, ...], Field(max_length=200)] = ()
    zone: Annotated[tuple[AnyZone, ...], Field(max_length=200)] = ()
    thickness: Thickness
    mass: Annotated[float, Field(gt=0.0, le=200.0, description="kg, weighed bare")]
    boundary: Literal["free", "clamped"] = "free"
    support: Annotated[tuple[Support, ...], Field(max_length=200)] = ()
    curvature: Curvature | None = None
    dimensions_at: Temperature | None = None
    expansion: Annotated[float, Field(ge=-1e-4, le=1e-3, description="1/K")] = 0.0
    mesh: ForeignMesh | None = None
    material: PlateMaterial | None = None

    @property
    def loop(self) -> Loop:
        """The outline."""
        if self.outline is None:
            return rectangle((0.5 * self.length_x, 0.5 * self.length_y), (self.length_x, self.length_y))
        return self.outline.loop

    @property
    def hole_loops(self) -> tuple[Loop, ...]:
        """The holes, in the order declared."""
        return tuple(hole.loop for hole in self.hole)

    @property
    def zone_loops(self) -> tuple[Loop, ...]:
        """The thickness zones, in the order declared."""
        return tuple(zone.loop for zone in self.zone)

    @property
    def area(self) -> float:
        """Area of the plate without its holes, m2."""
        return self.loop.area - sum(hole.area for hole in self.hole_loops)

    @property
    def volume(self) -> float:
        """Volume with the zones' own thickness, m3."""
        found = self.area * self.thickness
        for zone, loop in zip(self.zone, self.zone_loops, strict=True):
            holes = sum(hole.area for hole in self.hole_loops if loop.contains(just_inside(hole)[:1])[0])
            found += (zone.thickness - self.thickness) * (loop.area - holes)
        return found

    @property
    def density(self) -> float:
        """Mass over volume, kg/m3."""
        return self.mass / self.volume

    def grown(self, laws: Laws) -> Laws:
        """Laws with which a plate of the declared dimensions is as stiff as this one, grown with temperature."""
        if not self.expansion or self.dimensions_at is None:
            return laws
        return laws.grown(self.expansion, self.dimensions_at)

    def ungrown(self, box: MaterialBox) -> MaterialBox:
        """Materials that stay within `box` at every temperature, however the plate has grown."""
        if not self.expansion or self.dimensions_at is None:
            return box
        growth = 1.0 + self.expansion * (np.array(TEMPERATURES) - self.dimensions_at)
        low, high = box.youngs_modulus
        return replace(box, youngs_modulus=(float(low / growth.min()), float(high / growth.max())))

    @property
    def bounds(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Lower left and upper right corner of the bounding box, m."""
        if self.outline is None:
            return (0.0, 0.0), (self.length_x, self.length_y)
        low, high = self.outline.loop.bounds
        return (float(low[0]), float(low[1])), (float(high[0]), float(high[1]))

    def contains(self, points: Real) -> NDArray[np.bool_]:
        """Which of the points (K, 2), m, lie on the plate: its edges belong to it, its holes do not."""
        inside = self.loop.contains(points, within=TOUCH)
        for hole in self.hole_loops:
            inside &= ~hole.contains(points) | (hole.nearest(points).distance <= TOUCH)
        return inside

    def normalised(self, points: Real) -> tuple[Real, Real]:
        """Return xi and zeta (K,) of points (K, 2), m: -1 to 1 over the bounding box along x and y."""
        low, high = np.array(self.bounds)
        scaled = 2.0 * (np.asarray(points, float) - low) / (high - low) - 1.0
        return scaled[..., 0], scaled[..., 1]

    def height(self, points: Real) -> Real:
        """Height (K,) of the mid-plane over the plane of the drawing at points (K, 2), m."""
        if self.curvature is None:
            return np.zeros(len(points))
        return self.curvature.height_at(*self.normalised(points), self._half)

    def slope(self, points: Real) -> Real:
        """Slopes (K, 2) of the mid-plane along x and y at points (K, 2), m."""
        if self.curvature is None:
            return np.zeros((len(points), 2))
        return self.curvature.slope_at(*self.normalised(points), self._half)

    def supported_edges(self) -> list[SupportedEdge]:
        """Return what is held along the edges; where two supports meet, the later one counts."""
        declared = (Support(kind="clamped", edge="all"),) if self.boundary == "clamped" else self.support
        return supported_edges(declared, self._pieces)

    def _pieces(self, support: Support) -> tuple[Piece, ...]:
        outline = self.outline if support.hole is None else self.hole[support.hole - 1]
        names = outline is None or isinstance(outline, RectangleOutline)
        return support.pieces(self.loop if outline is None else outline.loop, names)

    def supported_discs(self) -> dict[str, tuple[Support, Loop]]:
        """Supports at points and their discs, by their names: ``support 1`` is the first of all supports."""
        return {
            f"support {k + 1}": (support, circle(support.point, support.radius))
            for k, support in enumerate(self.support)
            if support.point is not None
        }

    @property
    def _half(self) -> tuple[float, float]:
        return 0.5 * self.length_x, 0.5 * self.length_y

    @field_validator("outline")
    @classmethod
    def _has_an_extent(cls, value: AnyOutline | None, others: ValidationInfo) -> AnyOutline | None:
        """Of a field and not of the whole plate, to be told together with other keys that are missing."""
        missing = [name for name in ("length_x", "length_y") if np.isnan(others.data.get(name, 0.0))]
        if value is None and missing:
            they = " and ".join(f"plate.{name}" for name in missing)
            verb, them = ("is", "it") if len(missing) == 1 else ("are", "them")
            raise ValueError(f"{they} {verb} missing; give {them} in m (0.01 to 5), or [plate.outline]")
        return value

    @model_validator(mode="after")
    def _extent(self) -> Self:
        if self.outline is None:
            return self
        for axis, name in enumerate(("length_x", "length_y")):
            low, high = (corner[axis] for corner in self.bounds)
            # What the plate was dumped with comes back as it went; anything else declares the outline twice.
            if name in self.model_fields_set and not abs(getattr(self, name) - (high - low)) < TOUCH:
                raise ValueError(f"{name} and [plate.outline] both declare the outline; remove {name}")
            if not 0.01 <= high - low <= 5.0:
                raise GeometryError(
                    f"the outline spans {high - low:g} m along {'xy'[axis]}; allowed 0.01 to 5 (points in m?)",
                    *self.bounds,
                )
            self.__dict__[name] = high - low
        return self

    @model_validator(mode="after")
    def _grows_from_somewhere(self) -> Self:
        if self.expansion and self.dimensions_at is None:
            raise ValueError(
                f"expansion is {self.expansion:g} 1/K, dimensions_at is missing; give the temperature "
                "at which the dimensions hold, in °C (-80 to 200)"
            )
        return self

    @model_validator(mode="after")
    def _apart(self) -> Self:
        check_parts(self.loop, self.hole_loops, self.zone_loops)
        return self

    @model_validator(mode="after")
    def _plausible(self) -> Self:
        kind = None if self.material is None else self.material.kind
        low, high = density_range(kind)
        if not low <= self.density <= high:
            raise ValueError(
                f"mass {self.mass:g} kg over the plate's volume gives a density of {self.density:.4g} kg/m3; "
                f"allowed {low:g} to {high:g}{f' for {kind}' if kind else ''}: mass inconsistent with the area, "
                f"{self.area:.4g} m2, and the thickness, {self.thickness:g} m (lengths in m, mass in kg?)"
            )
        thickest = max(self.thickness, *(zone.thickness for zone in self.zone), 0.0)
        if thickest > min(self.length_x, self.length_y) / 5.0:
            raise ValueError(
                f"thickness {thickest:g} m is more than a fifth of the shorter side, "
                f"{min(self.length_x, self.length_y):g} m: not a plate"
            )
        if self.curvature is not None:
            self.curvature.check_bent(self._half, self.thickness)
        edge = self.loop.polygon
        steepest = np.hypot(*self.slope(edge).T)
        if steepest.max() > STEEPEST_SLOPE:
            place = edge[int(steepest.argmax())]
            raise GeometryError(
                f"curvature: the plate rises by {steepest.max():.3g} m per m at {at(place)}; allowed "
                f"{STEEPEST_SLOPE:g} in a shallow shell (radius in m?)",
                place,
            )
        return self

    @model_validator(mode="after")
    def _supported(self) -> Self:
        if self.boundary == "clamped" and self.support:
            raise ValueError(
                'boundary = "clamped" holds every edge already; remove it, and keep [[plate.support]]'
            )
        check_supports(self.support, self.loop, self.hole_loops, self._pieces)
        return self

    def _left_out(self) -> set[str]:
        """Leave out the extent that the outline gives."""
        return super()._left_out() | (set() if self.outline is None else {"length_x", "length_y"})
