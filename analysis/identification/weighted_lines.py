"""Inner products of the pole columns of an FRF model, by partial fractions, over lines with their weights.

A least-squares problem with J poles on F lines needs the inner products of its 4J columns (`pole_residue`), and to
form them line by line takes O(J^2 F) operations. On the imaginary axis the product of two columns is a difference
of single fractions,

    conj(1/(s - a)) 1/(s - b) = -[1/(s - b) - 1/(s + conj(a))] / (b + conj(a)),

so that all follow from one sum over the lines for each pole, G(lambda) = sum w 2 lambda/(s^2 - lambda^2), and its
derivative: O(J F + J^2) operations. The divisor's size is at least the sum of the two half widths, because a and
-conj(a) lie on different sides of the axis; close poles therefore cost no digits.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.identification.pole_residue import fill_columns

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


def _alternating(sums: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Products of the columns of Re R and Im R, alternating, (2J, N), from their conjugate sums (J, N)."""
    onto = np.empty((2 * len(sums), sums.shape[1]))
    onto[0::2], onto[1::2] = sums.real, -sums.imag
    return onto
