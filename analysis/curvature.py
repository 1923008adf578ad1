"""Shallow curvature of a plate: the height of its mid-plane over the plane it is drawn in."""

from typing import Annotated, Self

import numpy as np
from numpy.polynomial import polynomial
from pydantic import Field, model_validator

from analysis.arrays import Real
from analysis.declared import Sparse

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
