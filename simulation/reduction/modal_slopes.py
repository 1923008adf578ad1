"""Derivatives of the transfers of a modal form by changes of its stiffness."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from analysis.arrays import Complex, Real
from simulation.reduction.dashpots import connected, connected_derivatives
from simulation.reduction.modal_form import ModalForm
from simulation.reduction.pole_sums import PoleSums

SAME_POLE = 1e-9
"""Relative distance below which two poles count as one double pole."""


@dataclass(frozen=True)
class ModalSlopes:
    """a' Z**-1 b of I columns a and J columns b at F lines, with derivatives by the stiffness.

    The derivative for a change K' of the stiffness is -a' Z**-1 K' Z**-1 b. In modal coordinates the product of
    two terms 1/((p - s)(q - s)) is the difference of the single terms over q - p, so that a sum over pairs of
    poles and frequencies becomes one over pairs of poles and one over frequencies.

    Attributes
    ----------
    form : ModalForm
    frequency : (F,) ndarray
        Hz.
    left : (I + q, r) complex ndarray
        The columns a in modal coordinates, those of the q dashpots after them.
    right : (r, J + q) complex ndarray
        The columns b likewise.
    sums : PoleSums
    apart : (r, r) complex ndarray
        1/(q - p) of all pairs of poles; 0 for a double pole.
    double : (r, r) bool ndarray
        Pairs that count as a double pole.
    whole : (I + q, J + q, F) complex ndarray
        a' Z**-1 b without the dashpots.
    """

    form: ModalForm
    frequency: Real
    left: Complex
    right: Complex
    sums: PoleSums
    apart: Complex
    double: NDArray[np.bool_]
    whole: Complex

    @classmethod
    def of(
        cls, form: ModalForm, left: Real, right: Real, frequency: ArrayLike, sums: PoleSums | None = None
    ) -> Self:
        """Prepare derivatives for the columns a and b.

        Parameters
        ----------
        left : (r, I) ndarray
            The columns a.
        right : (r, J) ndarray
            The columns b.
        frequency : (F,) array_like, Hz
        sums : PoleSums, optional
            Of the form's poles at `frequency`, where they are known.

        Returns
        -------
        ModalSlopes
        """
        lines = np.atleast_1d(np.asarray(frequency, float))
        a, b = form.with_dashpots(left).T @ form.shapes, form.inverse @ form.with_dashpots(right)
        sums = sums or PoleSums.of(form.poles, lines)
        gap = form.poles[None, :] - form.poles[:, None]
        double = np.abs(gap) <= SAME_POLE * np.abs(form.poles)[:, None]
        apart = np.where(double, 0.0, 1.0 / np.where(double, 1.0, gap))
        return cls(form, lines, a, b, sums, apart, double, sums.simple(a[:, None] * b.T[None]))

    @property
    def compliance(self) -> Complex:
        """Return a' Z**-1 b, (I, J, F)."""
        return connected(self.whole, self.form.count, self.frequency)

    def with_dashpots(self, slopes: Complex) -> Complex:
        """Return derivatives of `compliance`, (D, I, J, F), from those of `whole`, (D, I + q, J + q, F)."""
        return connected_derivatives(self.whole, slopes, self.form.count, self.frequency)

    def by_stiffness(self, changes: Real) -> Complex:
        """Differentiate `whole` for D derivatives of the stiffness: one sum over poles, in a tenth of the time.

        Parameters
        ----------
        changes : (D, r, r) ndarray

        Returns
        -------
        (D, I + q, J + q, F) complex ndarray
        """
        a, b, size = self.left, self.right, len(self.form.poles)
        # a real matrix times a complex one, by real products: half of what two complex ones take
        shapes = np.ascontiguousarray(self.form.shapes).view(float)
        moved = (np.reshape(changes, (-1, size)) @ shapes).view(complex).reshape(-1, size, size)
        modal = self.form.inverse @ moved
        split = modal * self.apart
        simple = (a @ split)[:, :, None] * b.T - a[:, None] * (split @ b).swapaxes(1, 2)[:, None]
        own = np.where(self.double, modal, 0.0) @ b
        return self.sums.simple(simple) - self.sums.squared(a[:, None] * own.swapaxes(1, 2)[:, None])

    def by_columns(self, left: Real, right: Real) -> Complex:
        """Differentiate `whole` for D derivatives of the columns a (D, r, I) and b (D, r, J).

        Returns
        -------
        (D, I + q, J + q, F) complex ndarray
        """
        a, b, count = self.left, self.right, self.form.count
        moved_a = np.pad(left.swapaxes(1, 2) @ self.form.shapes, ((0, 0), (0, count), (0, 0)))
        moved_b = np.pad((self.form.inverse @ right).swapaxes(1, 2), ((0, 0), (0, count), (0, 0)))
        return self.sums.simple(moved_a[:, :, None] * b.T + a[:, None] * moved_b[:, None])
