"""Strain energy and inertia of a laminated Reissner-Mindlin shell, cell by cell; strains of a curved one.

Five fields: mid-plane displacements u, v, w (m) and the rotations thx, thy (rad) of the normal towards +x and +y,
so that a point at height z moves by (u + z thx, v + z thy, w). Eight strains follow from them: membrane (u,x; v,y;
u,y + v,x), curvature (thx,x; thy,y; thx,y + thy,x) and transverse shear (w,x + thx; w,y + thy). On a curved plate
of height Z(x, y) all strains gain terms of the slopes.

The mid-surface X = (x, y, Z(x, y)) has the tangents a_1 = (1, 0, Z,x) and a_2 = (0, 1, Z,y), the unit normal n and
the area sqrt(1 + Z,x**2 + Z,y**2) per area of the drawing. A point at height z over it moves by U + z D with the
displacement U = (u, v, w) and the director's D = (thx, thy, Z,x thx + Z,y thy), at right angles to n. To first
order in U and D (Naghdi, The theory of shells and plates, Handbuch der Physik VI a/2 (1972), sections 6 and 20)

    e_ab = (a_a . U,b + a_b . U,a)/2,    g_a = a_a . D + n . U,a,
    k_ab = (a_a . D,b + a_b . D,a + n,a . U,b + n,b . U,a)/2 .

Their physical components are those in the orthonormal frame of a_1 and n x a_1. The covariant membrane strains are
those of shallow shells (Marguerre, 1938); without metric, area and the terms of the slopes in k and g, natural
frequencies of a cylinder with a slope of 0.29 at its edges were off by -1.1 to +0.6 %, with them by 0.02 %.

In-plane stiffness of a layer along the plate's axes, and the moduli in which a plate's stiffness is affine.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from analysis.arrays import Real, Whole
from analysis.experiment import Plate
from analysis.material import Orthotropy
from simulation.shell.space import ShapeSpace

Form = dict[tuple[int, str], Real]
"""A linear form of the motion at K points: factors (K,) of fields and their derivatives."""
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


SHEAR_FACTOR = 5.0 / 6.0
"""Of a parabolic distribution of the transverse shear stress over the thickness."""
FIELDS = ("u", "v", "w", "thx", "thy")
U, V, W, THX, THY = range(5)
STRAINS: tuple[tuple[tuple[int, str], ...], ...] = (
    ((U, "x"),),
    ((V, "y"),),
    ((U, "y"), (V, "x")),
    ((THX, "x"),),
    ((THY, "y"),),
    ((THX, "y"), (THY, "x")),
    ((W, "x"), (THX, "0")),
    ((W, "y"), (THY, "0")),
)
"""Fields in every strain, each with its derivative: ``x``, ``y``, or ``0`` for the field itself."""
Weight = float | Real
"""A number, a value for every cell (cells,) or one for every point of quadrature (Q,)."""


class Block(NamedTuple):
    """Cells' matrices for two fields, where they are not zero.

    Attributes
    ----------
    row, column : int
        Fields.
    group : int
        0 for quadrilaterals, 1 for triangles.
    cells : (C,) ndarray of int
        In the group, ascending.
    values : (C, N, N) ndarray
    """

    row: int
    column: int
    group: int
    cells: Whole
    values: Real


@dataclass(frozen=True)
class Rigidity:
    """Symmetric 8 x 8 matrix of a laminate: section forces per strain, N/m, N and N m.

    Attributes
    ----------
    entries : mapping-like tuple of ((row, column), Weight)
        Upper triangle; missing entries are zero.
    surface : CurvedSurface, optional
        Of a curved plate, at the points of quadrature; entries are then (Q,) and per area of the drawing.
    """

    entries: tuple[tuple[tuple[int, int], Weight], ...]
    surface: CurvedSurface | None = None

    def terms(self) -> dict[tuple[int, int], dict[tuple[str, str], Weight]]:
        """Weights of products of derivatives, by pair of fields (row <= column) and pair of letters."""
        found: dict[tuple[int, int], dict[tuple[str, str], Weight]] = {}
        for (a, b), weight in self.entries:
            for row, column in {(a, b), (b, a)}:
                for f, d, more in self._parts(row):
                    for g, e, other in self._parts(column):
                        if f > g:
                            continue
                        term = _times(_times(weight, more), other)
                        pair = found.setdefault((f, g), {})
                        pair[d, e] = term if (d, e) not in pair else pair[d, e] + term
        return found

    def _parts(self, strain: int) -> list[tuple[int, str, Weight]]:
        if self.surface is None:
            return [(f, d, 1.0) for f, d in STRAINS[strain]]
        return [(f, d, factor) for (f, d), factor in self.surface.strains[strain].items()]


def _times(one: Weight, other: Weight) -> Weight:
    if isinstance(one, float) or isinstance(other, float) or np.shape(one) == np.shape(other):
        return one * other
    raise ValueError(
        f"weights of {np.shape(one)} and {np.shape(other)} values: give all per point, or all per cell"
    )


class CellMatrices:
    """Matrices of cells with weights; unweighted products are cached."""

    def __init__(self, space: ShapeSpace) -> None:
        self.space = space
        self._plain: dict[tuple[str, str, int], Real] = {}

    def of(self, rigidity: Rigidity) -> Iterator[Block]:
        """Stiffness: blocks of all pairs of fields with row <= column."""
        return self._summed(rigidity.terms())

    def inertia(
        self, straight: Weight, first: Weight | None, turning: Weight, slope: Real | None = None
    ) -> Iterator[Block]:
        """Mass from moments over the thickness.

        Parameters
        ----------
        straight : float or ndarray
            Mass per area, kg/m2: a number, or one for every cell or every point of quadrature.
        first : float or ndarray, optional
            First moment, kg/m; none for layers symmetric about the mid-plane.
        turning : float or ndarray
            Second moment, kg.
        slope : (2, Q) ndarray, optional
            Of a curved plate's mid-surface at the points of quadrature.
        """
        terms: dict[tuple[int, int], dict[tuple[str, str], Weight]] = {
            **{(k, k): {("0", "0"): straight} for k in (U, V, W)},
            **{(k, k): {("0", "0"): turning} for k in (THX, THY)},
        }
        if first is not None:
            terms |= {(U, THX): {("0", "0"): first}, (V, THY): {("0", "0"): first}}
        if slope is not None:  # the director moves along z, too, by Z,x thx + Z,y thy
            for k, field in enumerate((THX, THY)):
                terms[field, field] = {("0", "0"): turning * (1.0 + slope[k] ** 2)}
                if first is not None:
                    terms[W, field] = {("0", "0"): first * slope[k]}
            terms[THX, THY] = {("0", "0"): turning * slope[0] * slope[1]}
        return self._summed(terms)

    def normal(self) -> Iterator[Block]:
        """Integral of w times w, m2."""
        return self._summed({(W, W): {("0", "0"): 1.0}})

    def bent(self, weight: Weight) -> Iterator[Block]:
        """Half of the weighted product of w with the divergence of the rotation, as a symmetric form."""
        mixed = 0.5 * weight
        return self._summed({(W, THX): {("0", "x"): mixed}, (W, THY): {("0", "y"): mixed}})

    def _summed(self, terms: dict[tuple[int, int], dict[tuple[str, str], Weight]]) -> Iterator[Block]:
        for (f, g), pairs in terms.items():
            for group in (0, 1):
                weights = {pair: self._within(group, weight) for pair, weight in pairs.items()}
                cells = self._acting(group, list(weights.values()))
                if cells.size:
                    blocks = [self._product(d, e, group, weight, cells) for (d, e), weight in weights.items()]
                    yield Block(f, g, group, cells, sum(blocks[1:], start=blocks[0]))

    def _within(self, group: int, weight: Weight) -> Weight:
        """Weight on a group's cells: a number, (C,) by cell or (C, q) by point of quadrature."""
        if isinstance(weight, float):
            return weight
        (before, _), (count, each) = self.space.groups[0].dx.shape, self.space.groups[group].dx.shape
        by_cell = len(weight) == self.space.mesh.cells
        first = before if by_cell else self.space.groups[0].dx.size
        mine = weight[:first] if group == 0 else weight[first:]
        return mine if by_cell else mine.reshape(count, each)

    def _acting(self, group: int, weights: Sequence[Weight]) -> Whole:
        """Cells of a group on which some weight is not zero: most are not under a patch."""
        found = np.zeros(len(self.space.groups[group].dx), bool)
        for weight in weights:
            by_point = not isinstance(weight, float) and weight.ndim == 2
            found |= np.any(weight, axis=1) if by_point else np.asarray(weight) != 0.0
        return np.flatnonzero(found)

    def _product(self, row: str, column: str, group: int, weight: Weight, cells: Whole) -> Real:
        """Integral of weight times N_i (by ``row``) times N_j (by ``column``) on a group's cells, (C, N, N)."""
        whole = len(cells) == len(self.space.groups[group].dx)
        if not isinstance(weight, float) and weight.ndim == 2:
            return self.space.blocks(row, column, group, weight, None if whole else cells)
        plain = self._unweighted(row, column, group)
        by_cell = weight if isinstance(weight, float) else weight[cells, None, None]
        return np.asarray(by_cell * (plain if whole else plain[cells]))

    def _unweighted(self, row: str, column: str, group: int) -> Real:
        key = (row, column, group)
        if key not in self._plain:
            turned = (column, row, group)
            self._plain[key] = (
                self._plain[turned].transpose(0, 2, 1)
                if turned in self._plain
                else self.space.blocks(row, column, group)
            )
        return self._plain[key]


def laminate(
    membrane: Sequence[Sequence[Weight]],
    coupling: Sequence[Sequence[Weight]] | None,
    bending: Sequence[Sequence[Weight]],
    shear: Sequence[Weight],
) -> tuple[tuple[tuple[int, int], Weight], ...]:
    """Entries of `Rigidity` from the matrices A, B, D of a laminate and its transverse shear stiffness.

    Parameters
    ----------
    membrane : (3, 3) sequence of float or ndarray
        A, N/m.
    coupling : (3, 3) sequence of float or ndarray, optional
        B, N; none for layers symmetric about the mid-plane.
    bending : (3, 3) sequence of float or ndarray
        D, N m.
    shear : (3,) sequence of float or ndarray
        Of the strains xz and yz, and of both together, N/m.

    Returns
    -------
    tuple of ((int, int), float or ndarray)
        Places among the eight strains, upper triangle, and values; zeros are left out.
    """
    entries: list[tuple[tuple[int, int], Weight]] = []
    for i in range(3):
        for j in range(i, 3):
            entries += [((i, j), membrane[i][j]), ((3 + i, 3 + j), bending[i][j])]
        if coupling is not None:
            entries += [((i, 3 + j), coupling[i][j]) for j in range(3)]
    entries += zip(((6, 6), (7, 7), (6, 7)), shear, strict=True)
    return tuple((place, value) for place, value in entries if not (isinstance(value, float) and value == 0.0))


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


InPlane = tuple[Weight, Weight, Weight, Weight, Weight, Weight]
"""Q11, Q22, Q12, Q66, Q16, Q26 of a layer, Pa."""
Transverse = tuple[Weight, Weight, Weight]
"""Transverse shear stiffness of the strains xz and yz, and of both together, Pa."""


def moduli(
    sheet: Orthotropy, c1: Weight, c2: Weight, x: Weight = 1.0, y: Weight = 1.0, shear: Weight = 1.0
) -> InPlane:
    """Stiffness Q of a sheet along the plate's axes.

    Parameters
    ----------
    sheet : Orthotropy
        As declared.
    c1, c2 : float or ndarray
        E/(1 - nu**2) and nu times that, Pa: numbers, or one for every cell or point of quadrature.
    x, y, shear : float or ndarray
        Factors on E_x, E_y and the in-plane shear modulus in the sheet's own axes, in addition to its declared
        orthotropy.

    Returns
    -------
    tuple of six
        Q11, Q22, Q12, Q66, Q16 and Q26, Pa.
    """
    x, y, shear = (1.0 - sheet.delta_e) * x, (1.0 + sheet.delta_e) * y, (1.0 + sheet.delta_g) * shear
    own = (c1 * x, c1 * y, c2 * (x * y) ** 0.5, 0.5 * (c1 - c2) * shear)
    return (*own, 0.0, 0.0) if sheet.angle == 0.0 else _turned(own, sheet.angle)


def matrix(q: InPlane) -> list[list[Weight]]:
    """Q as a matrix (3, 3) over the strains xx, yy and xy."""
    q11, q22, q12, q66, q16, q26 = q
    return [[q11, q12, q16], [q12, q22, q26], [q16, q26, q66]]


def transverse(sheet: Orthotropy, shear: Weight, x: Weight = 1.0, y: Weight = 1.0) -> Transverse:
    """Transverse shear stiffness of a sheet along the plate's axes.

    Parameters
    ----------
    sheet : Orthotropy
        As declared.
    shear : float or ndarray
        E/2(1 + nu), Pa.
    x, y : float
        Factors on the moduli of the planes xz and yz in the sheet's own axes.

    Returns
    -------
    tuple of three
        Of the strains xz and yz, and of both together, Pa.
    """
    first, second = x * sheet.transverse[0], y * sheet.transverse[1]
    c, s = float(np.cos(sheet.angle)), float(np.sin(sheet.angle))
    if sheet.angle == 0.0:
        return first * shear, second * shear, 0.0
    return (
        (c * c * first + s * s * second) * shear,
        (s * s * first + c * c * second) * shear,
        c * s * (first - second) * shear,
    )


def _turned(own: tuple[Weight, Weight, Weight, Weight], angle: float) -> InPlane:
    """Q of a layer whose own axes are turned by `angle` (Jones, Mechanics of Composite Materials, eq. 2.80)."""
    q11, q22, q12, q66 = own
    c, s = float(np.cos(angle)), float(np.sin(angle))
    mixed = q12 + 2.0 * q66
    return (
        c**4 * q11 + 2.0 * c * c * s * s * mixed + s**4 * q22,
        s**4 * q11 + 2.0 * c * c * s * s * mixed + c**4 * q22,
        c * c * s * s * (q11 + q22 - 4.0 * q66) + (c**4 + s**4) * q12,
        c * c * s * s * (q11 + q22 - 2.0 * q12 - 2.0 * q66) + (c**4 + s**4) * q66,
        c**3 * s * (q11 - mixed) - c * s**3 * (q22 - mixed),
        c * s**3 * (q11 - mixed) - c**3 * s * (q22 - mixed),
    )


def plane_stress_moduli(youngs_modulus: float, poisson_ratio: float) -> tuple[float, float]:
    """C1 = E/(1 - nu**2) and C2 = nu C1, Pa: the stiffness is affine in these two."""
    c1 = youngs_modulus / (1.0 - poisson_ratio**2)
    return c1, poisson_ratio * c1
