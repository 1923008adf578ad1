"""The lines of an FRF that a fit uses, each with its weight, and inner products of pole columns over them.

A least-squares problem with J poles on F lines needs the inner products of its 4J columns (`pole_residue`), and to
form them line by line takes O(J^2 F) operations. On the imaginary axis the product of two columns is a difference
of single fractions,

    conj(1/(s - a)) 1/(s - b) = -[1/(s - b) - 1/(s + conj(a))] / (b + conj(a)),

so that all follow from one sum over the lines for each pole, G(lambda) = sum w 2 lambda/(s^2 - lambda^2), and its
derivative: O(J F + J^2) operations. The divisor's size is at least the sum of the two half widths, because a and
-conj(a) lie on different sides of the axis; close poles therefore cost no digits.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from analysis.identification.modes import DampingPrior
from analysis.identification.pole_residue import ResidualTerms, fill_columns
from analysis.identification.settings import LEAST_LINES


def running_median(
    values: NDArray[np.float64], window: int, mode: Literal["nearest", "reflect"]
) -> NDArray[np.float64]:
    """Median over a window that runs along the last axis.

    Computed row by row, because SciPy updates the sorted window only for one-dimensional arrays and sorts it anew
    at every line otherwise: 3 s instead of 8 ms for 48,000 lines and a window of 3,000.

    Parameters
    ----------
    values : (K, F) ndarray
    window : int
        Lines.
    mode : str
        Extension beyond the ends, as in `scipy.ndimage.median_filter`.

    Returns
    -------
    (K, F) ndarray
    """
    return np.array([median_filter(row, size=window, mode=mode) for row in values]).reshape(values.shape)


Curve = tuple[NDArray[np.complex128], NDArray[np.complex128], NDArray[np.complex128] | None]
"""Poles (J,), G at the poles, and its derivative if there is one."""


@dataclass(frozen=True)
class PoleProducts:
    """Inner products of the weighted columns of some poles.

    Attributes
    ----------
    rows : (I, N) ndarray
        Products of the first rows with all rows.
    poles : (J,) complex ndarray
        rad/s.
    value, slope : (J,) complex ndarray
        G(lambda), and its derivative, or None without derivative columns.
    onto, moved : (2J, N) ndarray
        Products of the columns, and of the derivative columns, with the rows.
    times : (J, N) complex ndarray
        G with a row times the weight in place of the squared weight.
    """

    rows: NDArray[np.float64]
    poles: NDArray[np.complex128]
    value: NDArray[np.complex128]
    slope: NDArray[np.complex128] | None
    onto: NDArray[np.float64]
    moved: NDArray[np.float64]
    times: NDArray[np.complex128]

    def gram(self, before: int) -> NDArray[np.float64]:
        """Lower triangle of the Gram matrix of columns, some rows, derivative columns, and the rest of the I rows.

        Parameters
        ----------
        before : int
            Number of rows placed before the derivative columns.

        Returns
        -------
        (M, M) ndarray
            M = 2J + I, with derivatives 4J + I; zero above the diagonal blocks.
        """
        own, moving, rows = len(self.onto), len(self.moved), self.rows[:, : len(self.rows)]
        first, last = slice(own, own + before), slice(own + before + moving, None)
        moved = slice(own + before, own + before + moving)
        gram = np.zeros((own + moving + len(rows),) * 2)
        blocks, onto = _between(self._curve, self._curve), self.onto[:, : len(rows)]
        gram[:own, :own] = blocks[0]
        gram[first, :own], gram[last, :own] = onto[:, :before].T, onto[:, before:].T
        gram[first, first], gram[last, first] = rows[:before, :before], rows[before:, :before]
        gram[last, last] = rows[before:, before:]
        if moving:
            onto = self.moved[:, : len(rows)]
            gram[moved, :own], gram[moved, moved] = blocks[1].T, blocks[2]
            gram[moved, first], gram[last, moved] = onto[:, :before], onto[:, before:].T
        return gram

    def with_columns_of(self, others: "PoleProducts", before: int) -> NDArray[np.float64]:
        """Products of the rows of `gram`, derivatives included, with the columns of other poles: (4J + N, 2G)."""
        columns, moved = _between(replace(others, slope=None)._curve, self._curve)
        return np.concatenate([columns.T, others.onto[:, :before].T, moved.T, others.onto[:, before:].T])

    def times_row(self, row: int) -> NDArray[np.float64]:
        """Products of columns with columns times a row, Re sum weight conj(column_i) row column_j: (2J, 2J)."""
        conjugate = self.onto[0::2, row] - 1j * self.onto[1::2, row]
        products: NDArray[np.float64] = _between(
            (self.poles, conjugate, None), (self.poles, self.times[:, row], None)
        )[0]
        return products

    @property
    def squares(self) -> NDArray[np.float64]:
        """Squared lengths of the columns, (2J,)."""
        even, odd = -self.value / self.poles.real, -self.value / self.poles
        return np.stack([even.real + odd.real, even.real - odd.real], axis=1).ravel()

    @property
    def _curve(self) -> Curve:
        return self.poles, self.value, self.slope


VALUES_AT_ONCE = 50_000
"""Number of values, lines times poles, that are computed at once."""


@dataclass(frozen=True)
class WeightedLines:
    """Lines with their weights, and further weighted rows: residual terms and data.

    Attributes
    ----------
    w, weight : (F,) ndarray
        rad/s, and what columns are multiplied by.
    rows : (N, F) complex ndarray
        Weighted.
    measure : (M, F) ndarray
        What the pole functions are multiplied by and summed: squared weights, then, times the weights, w Im of the
        rows and Re of the rows, as far as they are not zero.
    filled : (M,) ndarray of int
        Places of the rows of `measure` among all 1 + 2N.
    products : (I, N) ndarray
        Inner products of the first rows with all rows.
    """

    w: NDArray[np.float64]
    weight: NDArray[np.float64]
    rows: NDArray[np.complex128]
    measure: NDArray[np.float64]
    filled: NDArray[np.intp]
    products: NDArray[np.float64]

    @classmethod
    def of(
        cls,
        w: NDArray[np.float64],
        weight: NDArray[np.float64],
        rows: NDArray[np.complex128],
        inner: int | None = None,
    ) -> "WeightedLines":
        """Prepare lines.

        Parameters
        ----------
        w, weight : (F,) ndarray
            rad/s, and what columns are multiplied by.
        rows : (N, F) complex ndarray
            Weighted.
        inner : int, optional
            Number I of rows whose inner products with the others are needed; all by default.
        """
        measure = np.concatenate([(weight**2)[None], rows.imag * (weight * w), rows.real * weight])
        filled = np.flatnonzero(measure.any(axis=1))  # residual terms are real or imaginary
        return cls(w, weight, rows, measure[filled], filled, rows[:inner].view(float) @ rows.view(float).T)

    def at(self, poles: NDArray[np.complex128], *, derivatives: bool = False) -> "PoleProducts":
        """Sum over the lines for poles (J,), rad/s, in the upper half plane, and for their derivative columns."""
        pole, rows = poles[:, None], len(self.rows)
        once, twice = self._fractions(poles, derivatives)
        weight, odd, even = once[:, 0], once[:, 1 : 1 + rows], pole * once[:, 1 + rows :]
        value, onto, times = -2.0 * poles * weight, -2.0 * (odd + even), 2.0 * (odd - even)
        if not derivatives:
            return PoleProducts(self.products, poles, value, None, _alternating(onto), np.zeros((0, rows)), times)
        bent = pole * twice
        slopes = 2.0 * pole * bent
        moved = -2.0 * (once[:, 1 + rows :] - 2.0 * bent[:, 1 : 1 + rows] - slopes[:, 1 + rows :])
        slope = -2.0 * (weight - slopes[:, 0])
        return PoleProducts(self.products, poles, value, slope, _alternating(onto), _alternating(moved), times)

    def line_by_line(
        self, poles: NDArray[np.complex128], before: int, *, derivatives: bool
    ) -> NDArray[np.float64]:
        """Write the weighted columns and rows out.

        Parameters
        ----------
        poles : (J,) complex ndarray
            rad/s.
        before : int
            Number of rows placed before the derivative columns.
        derivatives : bool
            Whether the columns of 1/(s - lambda)^2 are among them.

        Returns
        -------
        (M, 2F) ndarray
            Real and imaginary parts alternating, in the order of `PoleProducts.gram`.
        """
        shape = (2 if derivatives else 1, 2 * len(poles), len(self.w))
        columns: NDArray[np.complex128] = np.empty(shape, dtype=complex)
        s = np.asarray(1j * self.w, dtype=np.complex128)
        fill_columns(s, poles, columns[0], columns[1] if derivatives else None)
        columns *= self.weight
        rows = np.concatenate([columns[0], self.rows[:before], *columns[1:], self.rows[before:]])
        return rows.view(float)

    def _fractions(
        self, poles: NDArray[np.complex128], derivatives: bool
    ) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        """Sum q and, with derivatives, q^2 times the measure over the lines, q = 1/(w^2 + lambda^2)."""
        place, half = poles.imag[:, None], poles.real[:, None]
        y = 2.0 * poles.real * poles.imag  # q = 1/(x + jy)
        few = max(VALUES_AT_ONCE // len(self.w), 1)
        sums = np.zeros((1 + 2 * len(self.rows), 4 if derivatives else 2, len(poles)))
        for start in range(0, len(poles), few):
            part = slice(start, start + few)
            values = np.empty((sums.shape[1], len(poles[part]), len(self.w)))
            size, real = values[:2]  # 1/|x + jy|^2, and the real part of q
            np.subtract(self.w, place[part], out=real)  # not w^2 - place^2, which loses digits near a resonance
            np.add(self.w, place[part], out=size)
            real *= size
            real += half[part] ** 2
            np.multiply(real, real, out=size)
            size += y[part, None] ** 2
            np.divide(1.0, size, out=size)
            real *= size
            if derivatives:
                np.multiply(size, size, out=values[2])
                np.multiply(real, size, out=values[3])
            found = self.measure @ values.reshape(-1, len(self.w)).T
            sums[self.filled, :, part] = found.reshape(len(found), len(values), -1)
        once = (sums[:, 1] - 1j * (y * sums[:, 0])).T
        if not derivatives:
            return once, once[:, :0]
        return once, (sums[:, 0] - 2.0 * y**2 * sums[:, 2] - 2j * (y * sums[:, 3])).T


MEDIAN_GAPS = 5
"""Gaps whose median is the spacing of uneven lines at a place: up to two of them may be holes."""
EVEN_GAP_RATIO = 0.9
"""Ratio of the smallest of these medians to the largest above which lines are even."""
SAME_WEIGHT = 1e-8
"""Difference below which two weights, whose rms is about 1, are one."""
SAME_LINE = 1e-6
"""Relative distance of two lines below which one was measured twice: no resonance is so narrow."""


@dataclass(frozen=True)
class WeightGroup:
    """Responses whose weights are proportional to each other.

    Attributes
    ----------
    weight : (2F,) ndarray
        Of the real and the imaginary part of every line, alternating.
    rows : (N,) ndarray of int
        Responses.
    scales : (N,) ndarray
        1/deviation = scale * weight.
    data : (N, 2F) ndarray
        Measured, weighted, in units of the deviations.
    """

    weight: NDArray[np.float64]
    rows: NDArray[np.intp]
    scales: NDArray[np.float64]
    data: NDArray[np.float64]

    @classmethod
    def of(
        cls, h: NDArray[np.complex128], weight: NDArray[np.float64], rows: list[int], scales: list[float]
    ) -> "WeightGroup":
        """Apply weights to some rows of FRFs.

        Parameters
        ----------
        h : (K, F) complex ndarray
        weight : (F,) ndarray
        rows : list of int
            N of the K.
        scales : list of float
            One for each of these.
        """
        data = h[rows] * np.array(scales)[:, None] * weight
        return cls(np.repeat(weight, 2), np.array(rows), np.array(scales), data.view(float))


@dataclass(frozen=True)
class Lines:
    """FRFs of one condition with the standard deviation of every line.

    Attributes
    ----------
    frequency : (F,) ndarray
        Hz, ascending, above zero.
    h : (K, F) complex ndarray
        FRFs from one drive to K responses.
    deviation : (K, F) ndarray
        Square root of E|h - H|^2; above zero.
    hidden : int
        Complex values removed by averaging neighbouring lines: they still count as measured, each with a misfit of
        1.
    as_measured : (G,) ndarray, optional
        Frequencies before any averaging, Hz; `frequency` unless given.
    correlation : float
        Number of lines that carry the information of one independent line, tau = 1 + 2 sum rho_k with the errors'
        autocorrelation rho_k; 1 where lines are independent.
    shared : float
        Number of responses that carry the information of one independent response, see
        `noise.shared_by_responses`; 1 where their errors are independent.
    damping : DampingPrior, optional
        Prior of the modes' damping ratios, added to the misfit of a fit.
    at_rest : bool
        Whether they come from records without a window, at the end of which the response was at rest.
    shift : float
        Relative standard deviation of all frequencies while the lines were measured, see `analysis.recordings.h1`.
    together : bool
        Whether the FRFs come from the same records, so that the structure is the same in all of them.
    """

    frequency: NDArray[np.float64]
    h: NDArray[np.complex128]
    deviation: NDArray[np.float64]
    hidden: int = 0
    as_measured: NDArray[np.float64] | None = None
    correlation: float = 1.0
    shared: float = 1.0
    damping: DampingPrior | None = None
    at_rest: bool = False
    shift: float = 0.0
    together: bool = False

    def __post_init__(self) -> None:
        if self.h.ndim != 2 or self.h.shape[1] != len(self.frequency) or self.deviation.shape != self.h.shape:
            raise ValueError(
                f"h {self.h.shape} and deviation {self.deviation.shape} must be (K, F) with "
                f"F = {len(self.frequency)} frequencies"
            )
        if len(self.frequency) < LEAST_LINES:
            raise ValueError(
                f"{len(self.frequency)} frequency lines are too few to identify a pole; {LEAST_LINES} needed"
            )
        if not self.frequency[0] > 0.0 or not (np.diff(self.frequency) > 0.0).all():
            raise ValueError("frequencies must ascend from above 0 Hz")
        if not np.isfinite(self.h).all():
            raise ValueError("the FRF holds values that are not finite")
        if not (np.isfinite(self.deviation).all() and (self.deviation > 0.0).all()):
            raise ValueError("standard deviations of lines must be above 0")
        if not 1.0 <= self.correlation < np.inf:
            raise ValueError(f"correlation {self.correlation:g} of lines: 1 or more wanted")
        if not 1.0 <= self.shared < np.inf:
            raise ValueError(f"{self.shared:g} responses that share their errors: 1 or more wanted")

    @property
    def s(self) -> NDArray[np.complex128]:
        """Points jw on the imaginary axis, rad/s."""
        points: NDArray[np.complex128] = np.asarray(2j * np.pi * self.frequency, dtype=np.complex128)
        return points

    @property
    def grid(self) -> NDArray[np.float64]:
        """Frequencies before any averaging, Hz."""
        return self.frequency if self.as_measured is None else self.as_measured

    @cached_property
    def even(self) -> bool:
        """Whether the lines have one spacing, gaps of lines left out aside."""
        return bool(self._around.min() > EVEN_GAP_RATIO * self._around.max())

    @cached_property
    def spacing(self) -> float:
        """Distance of neighbouring lines as measured, Hz; of uneven ones where they are densest."""
        return float(np.median(np.diff(self._distinct)) if self.even else self._around.min())

    def spacing_at(self, frequency: NDArray[np.float64] | float) -> NDArray[np.float64]:
        """Distance of the lines around some frequencies, Hz, of the same shape.

        A stepped sine has its lines at the resonances, a logarithmic sweep at low frequencies.
        """
        if self.even:
            return np.full(np.shape(frequency), self.spacing)
        middle = 0.5 * (self._distinct[1:] + self._distinct[:-1])
        return np.asarray(self._around[np.minimum(np.searchsorted(middle, frequency), len(middle) - 1)])

    @cached_property
    def _distinct(self) -> NDArray[np.float64]:
        """Lines before any averaging, those measured twice once; Hz."""
        again = np.diff(self.grid) < SAME_LINE * self.grid[1:]
        return np.asarray(self.grid[np.append(True, ~again)])

    @cached_property
    def _around(self) -> NDArray[np.float64]:
        """Median of the gaps around every gap between lines, Hz."""
        return np.asarray(running_median(np.diff(self._distinct)[None], MEDIAN_GAPS, "nearest")[0])

    @property
    def band(self) -> tuple[float, float]:
        """First and last line, rad/s."""
        low, high = 2.0 * np.pi * self.frequency[[0, -1]]
        return float(low), float(high)

    @property
    def scale(self) -> float:
        """Geometric middle of the band, rad/s: the unit in which powers of s stay near 1."""
        return float(2.0 * np.pi * np.sqrt(self.frequency[0] * self.frequency[-1]))

    @property
    def values(self) -> int:
        """Number of real values measured."""
        return 2 * (self.h.size + self.hidden)

    @property
    def independent(self) -> float:
        """Number of independent real values among `values`, the n of an information criterion."""
        return self.values / self.redundancy

    @property
    def redundancy(self) -> float:
        """Number of values that carry the information of one independent value."""
        return self.correlation * self.shared

    @property
    def responses(self) -> float:
        """Number of responses with independent errors that carry the information of all."""
        return max(len(self.h) / self.shared, 1.0)

    @cached_property
    def _term_columns(self) -> dict[ResidualTerms, NDArray[np.complex128]]:
        return {}

    @cached_property
    def _weighted(self) -> dict[ResidualTerms, list[WeightedLines]]:
        return {}

    def weighted(self, terms: ResidualTerms) -> list[WeightedLines]:
        """Lines with residual terms (P) and data after them as rows, one item per weight group."""
        if terms not in self._weighted:
            fixed = self.term_columns(terms)
            self._weighted[terms] = [
                WeightedLines.of(
                    self.s.imag,
                    group.weight[::2],
                    np.concatenate([fixed * group.weight[::2], group.data.view(complex)]),
                )
                for group in self.weight_groups
            ]
        return self._weighted[terms]

    def term_columns(self, terms: ResidualTerms) -> NDArray[np.complex128]:
        """Columns of residual terms on these lines, (P, F), computed once."""
        if terms not in self._term_columns:
            self._term_columns[terms] = terms.columns(self.s, self.scale)
        return self._term_columns[terms]

    @cached_property
    def weight_groups(self) -> list["WeightGroup"]:
        """Responses whose deviations are proportional, so that they share one factorisation."""
        groups: list[tuple[NDArray[np.float64], list[int], list[float]]] = []
        for row, deviation in enumerate(self.deviation):
            level = float(np.sqrt(np.mean(deviation**2)))
            weight = level / deviation
            for known, rows, scales in groups:
                # most differ on the first line already: hundreds of rows are compared in pairs
                if abs(known[0] - weight[0]) <= SAME_WEIGHT and (np.abs(known - weight) <= SAME_WEIGHT).all():
                    rows.append(row)
                    scales.append(1.0 / level)
                    break
            else:
                groups.append((weight, [row], [1.0 / level]))
        return [WeightGroup.of(self.h, *group) for group in groups]


def _between(one: Curve, other: Curve) -> NDArray[np.float64]:
    """Products of columns with columns, with the other's derivative columns, and of both derivative columns.

    As many as there are derivatives, each (2J, 2G). For R = x + jy, Re <R_i u_i + conj(R_i) l_i, R_j u_j +
    conj(R_j) l_j> = Re(conj(R_i) R_j A + R_i R_j B) with u = 1/(s - lambda), l = 1/(s - conj(lambda)); derivatives
    of A and B by the poles give the second and the third.
    """
    poles, value, slope = one
    a = _divided((poles.conj(), value.conj(), None if slope is None else slope.conj()), other)
    b = _divided(one, other)
    blocks = np.empty((len(a), 2 * a.shape[1], 2 * a.shape[2]))
    blocks[:, 0::2, 0::2] = a.real + b.real
    blocks[:, 0::2, 1::2] = -a.imag - b.imag
    blocks[:, 1::2, 0::2] = a.imag - b.imag
    blocks[:, 1::2, 1::2] = a.real - b.real
    return blocks


def _divided(one: Curve, other: Curve) -> NDArray[np.complex128]:
    """-(G_i + G_j)/(lambda_i + lambda_j), its derivative by lambda_j, and by both: (3, 2 or 1, J, G)."""
    (poles, value, slope), (others, of_others, slope_of_others) = one, other
    inverse = 1.0 / (poles[:, None] + others)
    quotient = (value[:, None] + of_others) * inverse
    if slope_of_others is None:
        return -quotient[None]
    by_other = (quotient - slope_of_others) * inverse
    if slope is None:
        return np.stack([-quotient, by_other])
    by_both = (slope[:, None] + slope_of_others - 2.0 * quotient) * inverse**2
    return np.stack([-quotient, by_other, by_both])


def _alternating(sums: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Products of the columns of Re R and Im R, alternating, (2J, N), from their conjugate sums (J, N)."""
    onto = np.empty((2 * len(sums), sums.shape[1]))
    onto[0::2], onto[1::2] = sums.real, -sums.imag
    return onto
