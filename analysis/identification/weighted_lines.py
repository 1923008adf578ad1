"""Lines with their weights, for the sums over them from which all inner products of pole columns follow."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.identification.pole_products import PoleProducts
from analysis.identification.pole_residue import fill_columns

AT_ONCE = 50_000
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

        Returns
        -------
        WeightedLines
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
        few = max(AT_ONCE // len(self.w), 1)
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
